"""Points off the outline in plan: mirrors, windows, ghosts, doubled contours."""

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import CAUSE_COLORS, SRX, Scene, label, noise, outline, save, scene, sense, sheet

from luxloop.sensor_model.noise.calibration import CalibrationError
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.truth import Cause
from luxloop.sim.scripted.script import ScriptedActor, ScriptedObstacle


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(2, 2, 11.0, 7.4)
    _mirrors(panels[0, 0])
    _windows(panels[0, 1])
    _ghosts(panels[1, 0])
    _doubled(panels[1, 1])
    for axes in panels.flat:
        axes.set_aspect("equal")
    save(figure, "causes")


def _by_cause(axes: Axes, where: Scene, config: NoiseConfig, causes: tuple[Cause, ...]) -> None:
    """Draw the points of a scan, with the given causes on top."""
    scan, truth = sense(where, config)
    outline(axes, where.frame)
    for cause in (Cause.CLEAN, *causes):
        x, y, _ = scan.points_ego[truth.cause == cause].T
        name = cause.name.lower().replace("_", " ")
        axes.scatter(x, y, s=6 if cause is Cause.CLEAN else 12, color=CAUSE_COLORS[cause], label=f"{name} ({len(x)})")
    axes.legend(fontsize=8)


def _mirrors(axes: Axes) -> None:
    car = ScriptedActor(x_m=24.0, y_m=-2.0, yaw_deg=150.0, reflectivity=0.4)
    _by_cause(axes, scene(car), noise("mirror", "layer_overlap"), (Cause.MIRROR, Cause.LAYER_OVERLAP))
    axes.set(xlim=(20.8, 27.2), ylim=(-4.6, 0.6))
    label(axes, "An oncoming car at 24 m: points on its side mirrors", "x forward [m]", "y left [m]")


def _windows(axes: Axes) -> None:
    car = ScriptedActor(x_m=35.0, y_m=-1.0, yaw_deg=4.0, reflectivity=0.4)
    _by_cause(axes, scene(car), noise("mirror", "layer_overlap"), (Cause.LAYER_OVERLAP,))
    axes.set(xlim=(31.8, 38.2), ylim=(-3.6, 1.6))
    label(axes, "A car ahead at 35 m: upper layers see its rear window", "x forward [m]", "y left [m]")


def _ghosts(axes: Axes) -> None:
    bus = ScriptedActor(x_m=10.0, y_m=3.4, kind="bus", reflectivity=0.5)
    wall = ScriptedObstacle([(14.0, -8.0), (14.0, 1.9)], kind="wall", reflectivity=0.6)
    where = scene(bus, street=(wall,))
    axes.plot([14.0, 14.0], [-8.0, 1.9], color="0.35", linewidth=1.0)
    _by_cause(axes, where, noise("mirror", "layer_overlap", "ghost"), (Cause.GHOST,))
    axes.set(xlim=(1.5, 18.5), ylim=(-4.5, 9.0))
    label(axes, "A bus beside a bright wall, which is seen in its side", "x forward [m]", "y left [m]")


def _doubled(axes: Axes) -> None:
    """Draw a car seen by several units with three times the default calibration error."""
    car = ScriptedActor(x_m=14.0, y_m=-0.3, yaw_deg=30.0, reflectivity=0.4)
    where, default = scene(car), CalibrationError()
    strong = CalibrationError(enabled=True, yaw_sigma_deg=3 * default.yaw_sigma_deg, xy_sigma_m=3 * default.xy_sigma_m)
    scan, truth = sense(where, noise("mirror", "layer_overlap", calibration=strong))
    outline(axes, where.frame)
    for unit, color in ((0, "tab:blue"), (1, "tab:orange")):
        own = (scan.unit == unit) & (truth.actor_id >= 0)
        x, y, _ = scan.points_ego[own].T
        twice = np.count_nonzero(truth.cause[own] == Cause.DOUBLED)
        axes.scatter(
            x, y, s=7, color=color, label=f"{SRX.mounts[unit].name} unit: {own.sum()}, {twice} of them doubled"
        )
    axes.legend(fontsize=8, loc="lower right")
    axes.set(xlim=(10.8, 17.2), ylim=(-3.0, 2.2))
    label(axes, "Mounts off by three times the default: contours twice", "x forward [m]", "y left [m]")
