"""Small worlds for the sensor, and rigs of few beams."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sensor_model.lidar import Lidar
from sensor_model.noise import Dropout, LayerOverlap, MirrorNoise, NoiseConfig, RangeNoise
from sensor_model.rig import Mount, Rig, load_rig
from sensor_model.shapes import SHAPES
from sensor_model.unit import Fan, UnitModel
from sim.world import Actors, Ego, Kind, Obstacles, WorldFrame

LUX_RIG = load_rig("srx_six_lux", Path())
NO_OBSTACLES = Obstacles.from_polygons([], [])
EXACT = NoiseConfig(range=RangeNoise(enabled=False), dropout=Dropout(enabled=False))
"""No loss and no range error, but bodies as they are."""
PLAIN = NoiseConfig(
    RangeNoise(enabled=False), Dropout(enabled=False), MirrorNoise(enabled=False), LayerOverlap(enabled=False)
)
EGO_FRONT = 4.83 / 2


@dataclass(frozen=True)
class Thing:
    x: float
    y: float
    yaw: float = 0.0
    kind: Kind = Kind.CAR
    size: tuple[float, float, float] | None = None
    paint: float = 0.4
    id: int = 0

    @property
    def lwh(self):
        return self.size or SHAPES[self.kind].size


def world(*things, ego=(0.0, 0.0, 0.0), index=0):
    """A frame with these things in it; ids are their order unless given."""
    count = len(things)
    actors = Actors(
        id=np.array([thing.id or i for i, thing in enumerate(things)], dtype=np.int64),
        name=np.array([f"thing {i}" for i in range(count)], dtype=np.str_),
        kind=np.array([thing.kind for thing in things], dtype=np.uint8),
        pose_world=np.array([(t.x, t.y, t.yaw) for t in things], dtype=np.float64).reshape(-1, 3),
        velocity_world=np.zeros((count, 2)),
        acceleration_world=np.zeros((count, 2)),
        yaw_rate=np.zeros(count),
        size=np.array([thing.lwh for thing in things], dtype=np.float64).reshape(-1, 3),
        reflectivity=np.array([thing.paint for thing in things], dtype=np.float64),
    )
    ego = Ego(np.array(ego, dtype=np.float64), np.zeros(2), np.zeros(2), 0.0, np.array([4.83, 1.91, 1.67]))
    return WorldFrame(index, 0.08 * index, ego, actors)


def ahead(gap, y=0.0, **thing):
    """A car whose rear is `gap` in front of the ego's front [m]."""
    length = Thing(0.0, 0.0, **thing).lwh[0]
    return Thing(EGO_FRONT + gap + length / 2, y, **thing)


def scan(*things, noise=EXACT, seed=1, obstacles=NO_OBSTACLES, rig=LUX_RIG, index=0, ego=(0.0, 0.0, 0.0)):
    return Lidar(rig, noise, seed, obstacles).scan(world(*things, index=index, ego=ego))


def wall(*corners, height=3.0):
    return Obstacles.from_polygons([np.array(corners, dtype=np.float64)], [height])


def small_unit(fans=None, elevation_deg=(-6.0, 1.0, 9.0), range_min=0.3):
    """A coarse unit, so that the naive twin is quick."""
    layers = tuple(range(len(elevation_deg)))
    fans = fans or (Fan(layers, start_deg=60.0, stop_deg=-60.0, step_deg=7.5, gain_percent=(100.0,)),)
    return UnitModel(range_min, 200.0, 1.35, elevation_deg, (0.0,) * len(layers), (0.0,), fans)


def one_unit_rig(model, x=0.0, y=0.0, z=0.6, yaw_deg=0.0, pitch_deg=0.0, roll_deg=0.0):
    return Rig(0.0, (Mount("only", model, x, y, z, yaw_deg, pitch_deg, roll_deg),))


def beam_origins(scan, beams):
    """(N, 3) where the beam of each point starts; units that the table does not know start at its first one."""
    return beams.origin_ego[np.where(scan.unit < len(beams.origin_ego), scan.unit, 0)]


def beams_of(scan, beams):
    """(N,) row of the beam table of each point, found by its direction; -1 for units that the table does not know."""
    heading = scan.points_ego - beam_origins(scan, beams)
    found = np.full(len(scan), -1)
    for unit, layer in sorted(set(zip(beams.unit.tolist(), beams.layer.tolist(), strict=True))):
        points = np.flatnonzero((scan.unit == unit) & (scan.layer == layer))
        candidates = np.flatnonzero((beams.unit == unit) & (beams.layer == layer))
        found[points] = candidates[np.argmax(heading[points] @ beams.direction_ego[candidates].T, axis=1)]
    return found
