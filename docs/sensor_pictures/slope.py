"""The ramp of the catalog from the side: road, bodies and echoes, before the foot and on the ramp."""

from contextlib import closing
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import BODIES_AS_THEY_ARE, SRX, Floats, label, save, sheet

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.truth import NO_ACTOR, Part, ScanTruth
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import Obstacles, Terrain, WorldFrame
from luxloop.tracker.scan import Scan

BEFORE_S, ON_RAMP_S = 4.8, 8.0
ENLARGED = 5.0
BESIDE_M = 5.0
"""[m] Points farther than this from the road's middle are not drawn."""


@dataclass(frozen=True)
class Instant:
    """Instant of the scenario."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth

    @property
    def points_world(self) -> Floats:
        """(N, 3) points with their heights in the world [m]."""
        ego = self.frame.ego
        (pitch, roll), yaw = ego.attitude, ego.pose_world[2]
        points = self.scan.points_ego.astype(np.float64) @ _rotation(0, roll).T @ _rotation(1, pitch).T
        return points @ _rotation(2, yaw).T + [*ego.pose_world[:2], ego.ground_z]


def draw() -> None:
    """Write the picture."""
    obstacles, instants = _play()
    assert obstacles.terrain is not None
    figure, panels = sheet(2, 1, 11.0, 5.6)
    titles = ("Before the foot", "On the ramp")
    for axes, instant, title in zip(panels[:, 0], instants, titles, strict=True):
        _side(axes, instant, obstacles.terrain, title)
    save(figure, "slope")


def _play() -> tuple[Obstacles, list[Instant]]:
    """Return the obstacles and the two instants."""
    scenario = Scenario.load(paths()["ramp"])
    assert isinstance(scenario.traffic, SumoTraffic)
    with closing(SumoSource(scenario.traffic, scenario.folder, 100.0)) as source:
        obstacles = source.reset(scenario.seed)
        frames = [source.step() for _ in range(round(ON_RAMP_S / source.dt) + 1)]
    lidar = Lidar(SRX, BODIES_AS_THEY_ARE, scenario.sensor, scenario.seed, obstacles)
    shown = [frames[round(time / source.dt)] for time in (BEFORE_S, ON_RAMP_S)]
    return obstacles, [Instant(frame, *lidar.scan(frame)) for frame in shown]


def _side(axes: Axes, instant: Instant, terrain: Terrain, title: str) -> None:
    """Draw an instant."""
    frame, points = instant.frame, instant.points_world
    ego, actors = frame.ego, frame.actors
    x = np.arange(ego.pose_world[0] - 45.0, ego.pose_world[0] + 90.0, 1.0)
    axes.plot(x, terrain.height_at(np.column_stack([x, np.full(len(x), ego.pose_world[1])])), color="0.5")
    _body(axes, ego.pose_world, ego.size, ego.ground_z, ego.attitude, "tab:green")
    for row in range(len(actors)):
        _body(
            axes, actors.pose_world[row], actors.size[row], actors.ground_z[row], actors.attitude[row], "tab:blue"
        )  # fmt: skip
    near = np.abs(points[:, 1]) < BESIDE_M
    ground = near & (instant.truth.part == Part.GROUND)
    other = near & (instant.truth.actor_id != NO_ACTOR)
    axes.plot(*points[other][:, [0, 2]].T, ".", color="black", markersize=2)
    axes.plot(*points[ground][:, [0, 2]].T, ".", color="tab:orange", markersize=3)
    axes.set(xlim=(x[0], x[-1]), ylim=(ego.ground_z - 3.0, ego.ground_z + 6.5), aspect=ENLARGED)
    label(axes, f"{title}: {int(ground.sum())} echoes of the ground", "x [m]", "height [m]")


def _body(axes: Axes, pose: Floats, size: Floats, z: float, attitude: Floats, color: str) -> None:
    """Draw the box of a body from the side."""
    forward = 1.0 if abs(pose[2]) < 0.5 * np.pi else -1.0
    along, up = 0.5 * size[0] * np.array([1, -1, -1, 1, 1]), size[2] * np.array([0, 0, 1, 1, 0])
    cos, sin = np.cos(attitude[0]), np.sin(attitude[0])
    axes.plot(pose[0] + forward * (cos * along + sin * up), z - sin * along + cos * up, color=color, linewidth=1.0)


def _rotation(axis: int, angle: float) -> Floats:
    """Return the (3, 3) rotation about an axis."""
    one, other = ((1, 2), (2, 0), (0, 1))[axis]
    rotation = np.eye(3)
    rotation[[one, one, other, other], [one, other, one, other]] = (
        np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle),
    )  # fmt: skip
    return rotation
