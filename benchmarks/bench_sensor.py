"""The sensor: a whole scan, and its caster beside Embree on the same rays and the same bodies."""

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np

from sensor_model.beams import BeamTable, beam_table
from sensor_model.bodies import BodyShop, body_solids
from sensor_model.cast import Caster
from sensor_model.lidar import Lidar
from sensor_model.noise import NoiseConfig
from sensor_model.rig import load_rig
from sensor_model.shapes import SHAPES
from sensor_model.walls import walls_of
from sim.world import Actors, Ego, Kind, Obstacles, WorldFrame

sys.path.append(str(Path(__file__).parents[1] / "tests"))  # the meshes are those of the tests' oracle
from support.solid_mesh import body_mesh

VEHICLES = 50
REPEATS = 200
NO_OBSTACLES = Obstacles.from_polygons([], [])
KINDS = (Kind.CAR, Kind.CAR, Kind.CAR, Kind.SUV, Kind.VAN, Kind.TRUCK, Kind.BUS)


def rows() -> dict[str, dict[str, float | str | None]]:
    """Median times on a motorway of five lanes with 50 vehicles within 80 m."""
    beams = beam_table(load_rig("srx_six_lux", Path()))
    frame = motorway()
    scan_ms = whole_scan_ms(frame)
    ours_ms, embree_ms = caster_ms(beams, frame), embreex_ms(beams, frame)
    return {
        "sensor.centre_ray_scan_ms": {"value": scan_ms, "unit": "ms", "peer": None, "ratio": None},
        "sensor.over_embreex": {
            "value": embree_ms / ours_ms,
            "unit": "1",
            "peer": f"embreex: {embree_ms:.2f} ms, ours: {ours_ms:.2f} ms, scene update and cast",
            "ratio": embree_ms / ours_ms,
        },
    }


def motorway() -> WorldFrame:
    """Fifty vehicles, ten in each of five lanes 3.5 m apart, the ego in a gap of the middle one."""
    rng = np.random.default_rng(3)
    kinds = rng.choice(KINDS, VEHICLES)
    lane, place = np.arange(VEHICLES) % 5, np.arange(VEHICLES) // 5
    x = -75.0 + 15.0 * place + rng.uniform(-2.0, 2.0, VEHICLES)
    x += 20.0 * ((lane == 2) & (np.abs(x) < 12.0))
    actors = Actors(
        id=np.arange(VEHICLES),
        name=np.arange(VEHICLES).astype(np.str_),
        kind=kinds.astype(np.uint8),
        pose_world=np.column_stack([x, 3.5 * lane - 7.0, rng.normal(0.0, 0.05, VEHICLES)]),
        velocity_world=np.zeros((VEHICLES, 2)),
        acceleration_world=np.zeros((VEHICLES, 2)),
        yaw_rate=np.zeros(VEHICLES),
        size=np.array([SHAPES[Kind(kind)].size for kind in kinds]),
        reflectivity=rng.uniform(0.05, 0.8, VEHICLES),
    )
    ego = Ego(np.zeros(3), np.zeros(2), np.zeros(2), 0.0, np.array([4.83, 1.91, 1.67]))
    return WorldFrame(0, 0.0, ego, actors)


def whole_scan_ms(frame: WorldFrame) -> float:
    """Bodies, cast, loss, noise, scan and truth."""
    lidar = Lidar(load_rig("srx_six_lux", Path()), NoiseConfig(), seed=1, obstacles=NO_OBSTACLES)
    return median_ms(lambda: lidar.scan(frame))


def caster_ms(beams: BeamTable, frame: WorldFrame) -> float:
    """Placing the bodies and casting, which also counts what each body would show alone."""
    shop, caster, walls = BodyShop(mirrors=True, plain=False), Caster(beams), walls_of(NO_OBSTACLES)
    actors, ego_pose = frame.actors, frame.ego.pose_world
    return median_ms(lambda: caster.cast(shop.place(actors, ego_pose), walls, actors.reflectivity))


def embreex_ms(beams: BeamTable, frame: WorldFrame) -> float:
    """Placing the same bodies as triangles, building Embree's scene, and its nearest hits."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    actors = frame.actors
    shapes = [(Kind(kind), *size) for kind, size in zip(actors.kind, actors.size.tolist(), strict=True)]
    meshes = {shape: body_mesh(body_solids(*shape, mirrors=True, plain=False)) for shape in set(shapes)}
    vertices = [np.asarray(meshes[shape].vertices) for shape in shapes]
    starts = np.cumsum([0, *map(len, vertices)])
    faces = np.concatenate([meshes[shape].faces + start for shape, start in zip(shapes, starts, strict=False)])
    owner, corner = np.repeat(np.arange(VEHICLES), np.diff(starts)), np.concatenate(vertices)
    faces = faces.astype(np.int32)
    origins = beams.origin_ego[beams.unit].astype(np.float32)
    directions = beams.direction_ego.astype(np.float32)

    def update_and_cast() -> None:
        x, y, yaw = (actors.pose_world - frame.ego.pose_world)[owner].T
        cos, sin = np.cos(yaw), np.sin(yaw)
        placed = np.column_stack(
            [x + cos * corner[:, 0] - sin * corner[:, 1], y + sin * corner[:, 0] + cos * corner[:, 1], corner[:, 2]]
        )
        scene = EmbreeScene()
        TriangleMesh(scene, placed.astype(np.float32), faces)
        scene.run(origins, directions, query="DISTANCE")

    return median_ms(update_and_cast)


def median_ms(run: Callable[[], object]) -> float:
    """Median of `REPEATS` runs after a first one, which compiles."""
    run()
    times = []
    for _ in range(REPEATS):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return 1e3 * float(np.median(times))
