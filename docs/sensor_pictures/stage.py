"""Shared parts of the pictures of the sensor: small scenes, units, colours, outlines."""

from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.rig import SHIPPED, Mount, Rig, load_rig, load_unit
from luxloop.sensor_model.rig.unit import UnitModel
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Cause, ScanTruth
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

Floats = npt.NDArray[np.float64]

FOLDER = Path(__file__).parents[1] / "pictures"
LUX = load_unit("lux", SHIPPED)
SRX = load_rig("srx_six_lux", SHIPPED)

LOWER, UPPER = "tab:blue", "tab:orange"
CAUSE_COLORS = {
    Cause.CLEAN: "0.55",
    Cause.MIRROR: "magenta",
    Cause.LAYER_OVERLAP: "darkorange",
    Cause.GHOST: "tab:red",
}
_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])


@dataclass(frozen=True)
class Scene:
    """Instant of a scripted world."""

    frame: WorldFrame
    obstacles: Obstacles


def scene(*actors: ScriptedActor, street: tuple[ScriptedObstacle, ...] = ()) -> Scene:
    """Return the first frame of a script, in which all actors are at their scripted poses."""
    traffic = ScriptedTraffic(
        ego=ScriptedEgo(), actor=list(actors), obstacle=list(street), jitter_m=0.0, jitter_deg=0.0
    )
    source = ScriptedSource(traffic, Path(), range_m=200.0)
    obstacles = source.reset(seed=1)
    return Scene(source.step(), obstacles)


def noise(*kinds: str, **strengths: object) -> NoiseConfig:
    """Return only these kinds of noise, optionally with other strengths (`mirror=MirrorNoise(...)`)."""
    config = NoiseConfig()
    switched = {kind: replace(getattr(config, kind), enabled=kind in kinds) for kind in KINDS}
    return replace(config, **{**switched, **strengths})


def sense(where: Scene, config: NoiseConfig) -> tuple[Scan, ScanTruth]:
    """Return a scan of a scene by the shipped rig, and its truth."""
    return Lidar(SRX, config, SensorConfig(), 1, where.obstacles).scan(where.frame)


def one_unit(model: UnitModel) -> Rig:
    """Return a rig of one forward unit above the ego frame's x axis."""
    return Rig(0.0, (Mount("only", model, 0.0, 0.0, 0.55, yaw_deg=0.0, pitch_deg=0.0, roll_deg=0.0),))


def outline(axes: Axes, frame: WorldFrame) -> None:
    """Draw the boxes of all actors in plan."""
    for pose, size in zip(frame.actors.pose_world, frame.actors.size, strict=True):
        turn = np.array([[np.cos(pose[2]), np.sin(pose[2])], [-np.sin(pose[2]), np.cos(pose[2])]])
        x, y = (pose[:2] + 0.5 * _CORNERS * size[:2] @ turn).T
        axes.plot(x, y, color="0.7", linewidth=1.0)


def sheet(rows: int, columns: int, width: float, height: float) -> tuple[Figure, npt.NDArray[np.object_]]:
    """Return a figure with panels (rows, columns); size in inches."""
    return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", squeeze=False)


def label(axes: Axes, title: str, x: str, y: str) -> None:
    """Set the title and the axis labels of a panel."""
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)


def save(figure: Figure, name: str) -> None:
    """Write a picture, in few colours to keep it small."""
    path = FOLDER / f"sensor_{name}.png"
    figure.savefig(path, dpi=95)
    plt.close(figure)
