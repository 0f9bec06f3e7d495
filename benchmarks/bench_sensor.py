"""Benchmark of the sensor: whole scans, and its ray caster against Embree with the same rays and bodies."""

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from time import perf_counter

import numpy as np
import numpy.typing as npt

from luxloop.sensor_model.bodies.scene import Bodies, BodyFactory
from luxloop.sensor_model.bodies.shapes import SHAPES
from luxloop.sensor_model.bodies.walls import walls_of
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.raycaster import Raycaster
from luxloop.sensor_model.rig.beams import BeamTable, beam_table
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.world import Actors, Ego, Kind, Obstacles, WorldFrame

sys.path.append(str(Path(__file__).parents[1] / "tests"))  # for the meshes of the tests' oracle
from support.solid_mesh import body_mesh, pieces

Floats = npt.NDArray[np.float64]
Row = dict[str, float | str | None]

VEHICLES = 50
TRAFFIC = (10, 25, 50, 100)
BUILDINGS = 5000
DRIVE_FRAMES = 10
REPEATS = 100
NO_OBSTACLES = Obstacles.from_polygons([], [])
KINDS = (Kind.CAR, Kind.CAR, Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK, Kind.BUS)
RIG = load_rig("srx_six_lux", Path())
CENTRE_RAY, FOOTPRINT = SensorConfig(footprint=(1, 1)), SensorConfig(footprint=(9, 3))


def rows() -> dict[str, Row]:
    """Return median times on a motorway of five lanes with 50 vehicles within 80 m."""
    frame = motorway(VEHICLES)
    return {
        "sensor.centre_ray_scan_ms": _row(whole_scan_ms(CENTRE_RAY, frame), "ms"),
        "sensor.footprint_scan_ms": _row(whole_scan_ms(FOOTPRINT, frame), "ms"),
        "sensor.over_embreex": beside_embreex(CENTRE_RAY, frame),
        "sensor.footprint_over_embreex": beside_embreex(FOOTPRINT, frame),
        **{f"sensor.ms_per_1000_hit_beams_{count}veh": cost_of_hits(count) for count in TRAFFIC},
        f"sensor.{BUILDINGS}_far_buildings_over_none": cost_of_far_buildings(CENTRE_RAY, frame),
    }


def _row(value: float, unit: str, peer: str | None = None, ratio: float | None = None) -> Row:
    return {"value": value, "unit": unit, "peer": peer, "ratio": ratio}


def motorway(vehicles: int) -> WorldFrame:
    """Return vehicles every 15 m in five lanes 3.5 m apart, with the ego in a gap of the middle lane."""
    rng = np.random.default_rng(3)
    kinds = rng.choice(KINDS, vehicles)
    lane, place = np.arange(vehicles) % 5, np.arange(vehicles) // 5
    x = 15.0 * (place - vehicles // 10) + rng.uniform(-2.0, 2.0, vehicles)
    x += 20.0 * ((lane == 2) & (np.abs(x) < 12.0))
    actors = Actors(
        id=np.arange(vehicles),
        name=np.arange(vehicles).astype(np.str_),
        kind=kinds.astype(np.uint8),
        pose_world=np.column_stack([x, 3.5 * lane - 7.0, rng.normal(0.0, 0.05, vehicles)]),
        velocity_world=np.column_stack([rng.uniform(20.0, 40.0, vehicles), rng.normal(0.0, 0.3, vehicles)]),
        acceleration_world=rng.normal(0.0, 0.5, (vehicles, 2)),
        yaw_rate=rng.normal(0.0, 0.02, vehicles),
        articulation=np.zeros(vehicles),
        mode=np.zeros(vehicles, np.uint8),
        changes_lane=np.zeros(vehicles, np.bool_),
        deviation=np.zeros((vehicles, 2)),
        ground_z=np.zeros(vehicles),
        attitude=np.zeros((vehicles, 2)),
        size=np.array([SHAPES[Kind(kind)].size for kind in kinds]),
        reflectivity=rng.uniform(0.05, 0.8, vehicles),
    )
    ego = Ego(
        np.zeros(3),
        np.array([30.0, 0.0]),
        np.zeros(2),
        0.01,
        np.array([4.83, 1.91, 1.67]),
        False,
        np.zeros(2),
        0.0,
        np.zeros(2),
    )
    return WorldFrame(0, 0.0, ego, actors)


def whole_scan_ms(sensor: SensorConfig, frame: WorldFrame) -> float:
    """Return the time of bodies, cast, loss, noise, scan and truth."""
    lidar = Lidar(RIG, NoiseConfig(), sensor, seed=1, obstacles=NO_OBSTACLES)
    return median_ms(lambda: lidar.scan(frame))


def beside_embreex(sensor: SensorConfig, frame: WorldFrame) -> Row:
    """Return the time to place the bodies and cast all rays, against Embree.

    Ours includes sweep, hits of each body alone, and echo detection.
    """
    beams, factory = beam_table(RIG), _factory(sensor)
    caster, walls, context = Raycaster(beams, sensor), walls_of(NO_OBSTACLES), _context(beams, frame)
    ours_ms = median_ms(lambda: caster.cast(factory.place(frame), walls, context))
    embree_ms = embreex_ms(factory.place(frame), *ray_grid(beams, sensor.footprint))
    peer = f"embreex: {embree_ms:.2f} ms, ours: {ours_ms:.2f} ms, scene update and cast"
    return _row(embree_ms / ours_ms, "1", peer, embree_ms / ours_ms)


def thinned(frame: WorldFrame, vehicles: int) -> WorldFrame:
    """Return the frame with this number of randomly selected vehicles."""
    kept = np.sort(np.random.default_rng(4).permutation(len(frame.actors))[:vehicles])
    columns = {column.name: getattr(frame.actors, column.name)[kept] for column in fields(Actors)}
    return replace(frame, actors=Actors(**columns))


def cost_of_hits(vehicles: int) -> Row:
    """Return the time of a footprint cast per 1000 beams that hit a vehicle, on a road with room for 100."""
    frame, beams, factory = thinned(motorway(max(TRAFFIC)), vehicles), beam_table(RIG), _factory(FOOTPRINT)
    caster, walls, context = Raycaster(beams, FOOTPRINT), walls_of(NO_OBSTACLES), _context(beams, frame)
    echoes = caster.cast(factory.place(frame), walls, context)
    met = len(np.unique(np.concatenate([echoes.beam, echoes.lost_beam])))
    hit = len(np.unique(echoes.beam[echoes.target >= 0]))
    ms = median_ms(lambda: caster.cast(factory.place(frame), walls, context))
    return _row(1000.0 * ms / hit, "ms", f"{ms:.2f} ms, {hit} beams hit a vehicle, {met} of {len(beams)} anything")


def cost_of_far_buildings(sensor: SensorConfig, frame: WorldFrame) -> Row:
    """Return the time of a scan with a distant city, relative to one without, while the ego moves."""
    frames = [moved(frame, 30.0 * 0.08 * step) for step in range(DRIVE_FRAMES)]
    lidars = [Lidar(RIG, NoiseConfig(), sensor, seed=1, obstacles=some) for some in (far_city(BUILDINGS), NO_OBSTACLES)]

    def drive_ms(lidar: Lidar) -> float:
        start = perf_counter()
        for each in frames:
            lidar.scan(each)
        return 1e3 * (perf_counter() - start) / DRIVE_FRAMES

    # Alternately, because other load on the machine would affect a ratio near 1.
    drives = [[drive_ms(lidar) for lidar in lidars] for _ in range(1 + REPEATS)]
    city_ms, none_ms = np.median(drives[1:], axis=0)
    return _row(float(city_ms / none_ms), "1", f"{city_ms:.2f} ms, without: {none_ms:.2f} ms")


def moved(frame: WorldFrame, way: float) -> WorldFrame:
    """Return the frame with ego and actors moved along the road [m]."""
    ego, actors, ahead = frame.ego, frame.actors, np.array([way, 0.0, 0.0])
    return replace(
        frame,
        ego=replace(ego, pose_world=ego.pose_world + ahead),
        actors=replace(actors, pose_world=actors.pose_world + ahead),
    )


def far_city(buildings: int) -> Obstacles:
    """Return buildings every 60 m in rows of 50, on both sides of the road at a distance of at least 300 m."""
    outline = np.array([[0.0, 0.0], [25.0, 0.0], [25.0, 20.0], [0.0, 20.0]])
    row, column = np.divmod(np.arange(buildings), 50)
    y = (300.0 + 60.0 * (row // 2)) * np.where(row % 2, 1.0, -1.0) - 20.0 * (row % 2 == 0)
    corners = np.column_stack([60.0 * column - 1500.0, y])[:, None] + outline
    return Obstacles.from_polygons(list(corners), [10.0] * buildings)


def _factory(sensor: SensorConfig) -> BodyFactory:
    return BodyFactory(mirrors=True, plain=False, glass=sensor.glass, seed=1)


def _context(beams: BeamTable, frame: WorldFrame) -> ScanContext:
    units, ego = beams.units, frame.ego
    return ScanContext(
        frame_index=0,
        origin_ego=units.origin_ego,
        R_ego_unit=units.R_ego_unit,
        time_jitter=np.zeros(len(units)),
        ego_velocity=ego.velocity_world,
        ego_acceleration=ego.acceleration_world,
        ego_yaw_rate=ego.yaw_rate,
        threshold=units.threshold[beams.unit],
    )


def ray_grid(beams: BeamTable, footprint: tuple[int, int]) -> tuple[Floats, Floats]:
    """Return (G, 3) origins and directions in the ego frame of all rays of all beams, fired simultaneously."""
    rays_high, rays_wide = footprint
    unit = np.repeat(beams.unit, rays_high * rays_wide)
    rise = np.tile(np.repeat((np.arange(rays_high) + 0.5) / rays_high - 0.5, rays_wide), len(beams))
    turn = np.tile((np.arange(rays_wide) + 0.5) / rays_wide - 0.5, len(beams) * rays_high)
    azimuth = np.repeat(beams.azimuth, rays_high * rays_wide) + turn * beams.units.beam_width[unit]
    elevation = np.repeat(beams.elevation, rays_high * rays_wide) + rise * beams.units.beam_height[unit]
    cos = np.cos(elevation)
    direction = np.stack([cos * np.cos(azimuth), cos * np.sin(azimuth), np.sin(elevation)], axis=1)
    return beams.units.origin_ego[unit], np.einsum("gij,gj->gi", beams.units.R_ego_unit[unit], direction)


def embreex_ms(bodies: Bodies, origins: Floats, directions: Floats) -> float:
    """Return the time to place the outer solids as triangles, build Embree's scene and find nearest hits."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    outer = [[piece for piece in pieces(bodies, row) if not piece.inner] for row in range(len(bodies))]
    meshes = [body_mesh(solids) for solids in outer]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]).astype(np.int32)
    owner = np.repeat(np.arange(len(meshes)), np.diff(starts))
    corner = np.concatenate([np.asarray(mesh.vertices) for mesh in meshes])
    origins_32, directions_32 = origins.astype(np.float32), directions.astype(np.float32)

    def update_and_cast() -> None:
        x, y, yaw = bodies.pose_ego[owner].T
        cos, sin = np.cos(yaw), np.sin(yaw)
        placed = np.column_stack(
            [x + cos * corner[:, 0] - sin * corner[:, 1], y + sin * corner[:, 0] + cos * corner[:, 1], corner[:, 2]]
        )
        scene = EmbreeScene()
        TriangleMesh(scene, placed.astype(np.float32), faces)
        scene.run(origins_32, directions_32, query="DISTANCE")

    return median_ms(update_and_cast)


def median_ms(run: Callable[[], object]) -> float:
    """Return the median of `REPEATS` runs after a first one, which compiles."""
    run()
    times = []
    for _ in range(REPEATS):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return 1e3 * float(np.median(times))
