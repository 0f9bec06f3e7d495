"""Small scenes for the sensor, and rigs of few beams."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sensor_model.bodies.shapes import SHAPES
from luxloop.sensor_model.bodies.walls import walls_of
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import Mount, Rig, load_rig
from luxloop.sensor_model.rig.unit import Fan, UnitModel
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.world import JOINTS, Actors, Ego, Kind, Obstacles, WorldFrame


def only(*kinds):
    """Return a noise configuration with only these kinds, at default strength."""
    config = NoiseConfig()
    return replace(config, **{kind: replace(getattr(config, kind), enabled=kind in kinds) for kind in KINDS})


LUX_RIG = load_rig("srx_six_lux", Path())
NO_OBSTACLES = Obstacles.from_polygons([], [])
EXACT = only("mirror", "layer_overlap")
"""No random loss and no range error; detailed bodies."""
PLAIN = only()
"""In addition no mirrors, and bodies are boxes."""
FOOTPRINT = SensorConfig()
CENTRE_RAY = SensorConfig(footprint=(1, 1))
EGO_SIZE = (4.83, 1.91, 1.67)
EGO_FRONT = EGO_SIZE[0] / 2


@dataclass(frozen=True)
class ActorSpec:
    x: float
    y: float
    yaw: float = 0.0
    kind: Kind = Kind.CAR
    size: tuple[float, float, float] | None = None
    paint: float = 0.4
    id: int = 0
    velocity: tuple[float, float] = (0.0, 0.0)
    acceleration: tuple[float, float] = (0.0, 0.0)
    yaw_rate: float = 0.0
    articulation: float = 0.0
    further_articulation: tuple[float, ...] = (0.0,) * (JOINTS - 1)
    ground_z: float = 0.0
    attitude: tuple[float, float] = (0.0, 0.0)

    @property
    def lwh(self):
        return self.size or SHAPES[self.kind].size


STILL = ActorSpec(0.0, 0.0)


def world(*specs, ego=STILL, index=0):
    """Return a frame with these actors; ids default to their order. Only motion, height and attitude of `ego` count."""
    count = len(specs)
    actors = Actors(
        id=np.array([spec.id or i for i, spec in enumerate(specs)], dtype=np.int64),
        name=np.array([f"actor {spec.id or i}" for i, spec in enumerate(specs)], dtype=np.str_),
        kind=np.array([spec.kind for spec in specs], dtype=np.uint8),
        pose_world=np.array([(t.x, t.y, t.yaw) for t in specs], dtype=np.float64).reshape(-1, 3),
        velocity_world=np.array([spec.velocity for spec in specs], dtype=np.float64).reshape(-1, 2),
        acceleration_world=np.array([spec.acceleration for spec in specs], dtype=np.float64).reshape(-1, 2),
        yaw_rate=np.array([spec.yaw_rate for spec in specs], dtype=np.float64),
        articulation=np.array([spec.articulation for spec in specs], dtype=np.float64),
        further_articulation=np.array([spec.further_articulation for spec in specs]).reshape(-1, JOINTS - 1),
        mode=np.zeros(count, np.uint8),
        changes_lane=np.zeros(count, np.bool_),
        deviation=np.zeros((count, 2)),
        ground_z=np.array([spec.ground_z for spec in specs], dtype=np.float64),
        attitude=np.array([spec.attitude for spec in specs], dtype=np.float64).reshape(-1, 2),
        size=np.array([spec.lwh for spec in specs], dtype=np.float64).reshape(-1, 3),
        reflectivity=np.array([spec.paint for spec in specs], dtype=np.float64),
    )
    ego = Ego(
        pose_world=np.array([ego.x, ego.y, ego.yaw], dtype=np.float64),
        velocity_world=np.array(ego.velocity, dtype=np.float64),
        acceleration_world=np.array(ego.acceleration, dtype=np.float64),
        yaw_rate=ego.yaw_rate,
        size=np.array(EGO_SIZE),
        changes_lane=False,
        deviation=np.zeros(2),
        ground_z=ego.ground_z,
        attitude=np.array(ego.attitude),
    )
    return WorldFrame(index, 0.08 * index, ego, actors)


def ahead(gap, y=0.0, **spec):
    """Return a car whose rear is `gap` in front of the ego's front [m]."""
    length = ActorSpec(0.0, 0.0, **spec).lwh[0]
    return ActorSpec(EGO_FRONT + gap + length / 2, y, **spec)


def scan(*specs, noise=EXACT, sensor=FOOTPRINT, seed=1, obstacles=NO_OBSTACLES, rig=LUX_RIG, index=0, ego=STILL):
    return Lidar(rig, noise, sensor, seed, obstacles).scan(world(*specs, index=index, ego=ego))


def placed_scene(rig, sensor, frame, obstacles=NO_OBSTACLES, *, plain=False, mirrors=True, **circumstances):
    """Return beams, bodies, walls and context of a frame for a caster, with nominal mounts and without noise.

    `circumstances` change fields of the context.
    """
    beams = beam_table(rig)
    bodies = BodyFactory(mirrors=mirrors, plain=plain, glass=sensor.glass, seed=None).place(frame)
    cos, sin = np.cos(frame.ego.pose_world[2]), np.sin(frame.ego.pose_world[2])
    R_world_ego = np.array([[cos, -sin], [sin, cos]])
    context = ScanContext(
        frame_index=frame.index,
        origin_ego=beams.units.origin_ego,
        R_ego_unit=beams.units.R_ego_unit,
        time_jitter=np.zeros(len(beams.units)),
        ego_velocity=frame.ego.velocity_world @ R_world_ego,
        ego_acceleration=frame.ego.acceleration_world @ R_world_ego,
        ego_yaw_rate=frame.ego.yaw_rate,
        threshold=beams.units.threshold[beams.unit],
        extinction=0.0,
    )
    walls = walls_of(obstacles).seen_from(frame.ego.pose_world)
    return beams, bodies, walls, replace(context, **circumstances)


def wall(*corners, height=3.0, reflectivity=0.3, base=0.0):
    return walls((*corners,), height=height, reflectivity=reflectivity, base=base)


def walls(*polygons, height=3.0, reflectivity=0.3, base=0.0):
    corners = [np.array(polygon, dtype=np.float64) for polygon in polygons]
    return Obstacles.from_polygons(corners, [height] * len(corners), reflectivity, base)


def small_unit(fans=None, elevation_deg=(-6.0, 1.0, 9.0), **changes):
    """Return a coarse unit, for which the reference implementation is fast. Its sensitivity is that of the LUX."""
    layers = tuple(range(len(elevation_deg)))
    fans = fans or (Fan(layers, start_deg=60.0, stop_deg=-60.0, step_deg=7.5, gain_percent=(100.0,)),)
    values = {
        "scan_rate_hz": 12.5,
        "range_min_m": 0.3,
        "range_max_m": 200.0,
        "beam_width_deg": 0.08,
        "beam_height_deg": 0.784,
        "reference_reflectivity": 0.1,
        "reference_range_m": 50.0,
        "pulse_length_m": 0.675,
        "pulse_growth_m_per_db": 0.03,
        "pulse_quantum_m": 0.04,
        "pulse_sigma_m": 0.0,
        "echoes_max": 3,
        "echo_separation_m": 1.4,
        "range_sigma_m": 0.025,
        "range_sigma_far_m": 0.025,
        "range_quantum_m": 0.01,
        "layer_bias_m": (0.0,) * len(layers),
        "layer_pulse_bias_m": (0.0,) * len(layers),
        "gain_azimuth_deg": (0.0,),
        "turns": 1,
    }
    return UnitModel(layer_elevation_deg=elevation_deg, fans=fans, **(values | changes))


def one_unit_rig(model, x=0.0, y=0.0, z=0.6, yaw_deg=0.0, pitch_deg=0.0, roll_deg=0.0, phase_ms=0.0):
    return Rig(0.0, (Mount("only", model, x, y, z, yaw_deg, pitch_deg, roll_deg, phase_ms),))


def beam_origins(scan, beams):
    """Return (N, 3) origins of the points' beams; that of the first unit for units missing in the table."""
    return beams.units.origin_ego[np.where(scan.unit < len(beams.units), scan.unit, 0)]


def beams_of(scan, beams):
    """Return the (N,) row of the beam table of each point, by its direction; -1 for units missing in the table."""
    heading = scan.points_ego - beam_origins(scan, beams)
    found = np.full(len(scan), -1)
    for unit, layer in sorted(set(zip(beams.unit.tolist(), beams.layer.tolist(), strict=True))):
        points = np.flatnonzero((scan.unit == unit) & (scan.layer == layer))
        candidates = np.flatnonzero((beams.unit == unit) & (beams.layer == layer))
        found[points] = candidates[np.argmax(heading[points] @ beams.direction_ego[candidates].T, axis=1)]
    return found
