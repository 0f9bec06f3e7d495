"""Range errors: noise, bias of the layers, quantisation, and outliers."""

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.attitude import LAYER_COLORS
from sensor_pictures.stage import CAUSE_COLORS, LUX, Floats, label, noise, one_unit, save, scene, sheet

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.outliers import Outliers
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Cause, Part
from luxloop.sim.scripted.script import ScriptedObstacle

FRAMES = 150


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 2, 11.0, 3.8)
    _layers(panels[0, 0])
    _outliers(panels[0, 1])
    save(figure, "ranging")


def errors(config: NoiseConfig) -> tuple[Floats, Floats, Floats]:
    """Return the range errors [m] of all points on a wall, their layers and causes, over many frames."""
    rig: Rig = one_unit(LUX)
    where = scene(street=(ScriptedObstacle([(15.0, -40.0), (15.0, 40.0)], 20.0, kind="wall"),))
    lidar = Lidar(rig, config, SensorConfig(), 1, where.obstacles)
    found = []
    for index in range(FRAMES):
        scan, truth = lidar.scan(replace(where.frame, index=index))
        wall = truth.part == Part.OBSTACLE
        measured = np.linalg.norm(scan.points_ego[wall] - lidar.beams.units.origin_ego[0], axis=1)
        found.append((measured - truth.true_range[wall], scan.layer[wall], truth.cause[wall]))
    error, layer, cause = (np.concatenate(column) for column in zip(*found, strict=True))
    return error, layer, cause


def _layers(axes: Axes) -> None:
    error, layer, _ = errors(noise("range"))
    bins = np.arange(-0.1, 0.1001, 0.005)
    for number, color in enumerate(LAYER_COLORS):
        own = error[layer == number]
        bias = LUX.layer_bias_m[number]
        axes.hist(own, bins, density=True, histtype="step", color=color, linewidth=1.6,
                  label=f"layer {number}: bias {100 * bias:+.2f} cm, found {100 * own.mean():+.2f} cm")  # fmt: skip
        axes.axvline(bias, color=color, linestyle=":", linewidth=1)
    axes.set(xlim=(-0.1, 0.1), ylim=(0.0, 42.0))
    axes.legend(fontsize=8, loc="upper left")
    label(axes, "Range error by layer, on a wall", "reported minus true range [m]", "density [1/m]")


def _outliers(axes: Axes) -> None:
    config = Outliers(enabled=True)
    error, _, cause = errors(noise("range", outliers=config))
    bins = np.arange(-5.0, 5.01, 0.1)
    outlier = cause == Cause.RANGE_OUTLIER
    axes.hist(error[~outlier], bins, color=CAUSE_COLORS[Cause.CLEAN], label=f"clean ({np.count_nonzero(~outlier)})")
    axes.hist(error[outlier], bins, color=CAUSE_COLORS[Cause.RANGE_OUTLIER],
              label=f"range outlier ({np.count_nonzero(outlier)}; rate {config.rate:g})")  # fmt: skip
    axes.set(yscale="log", xlim=(-5.0, 5.0))
    axes.legend(fontsize=8)
    label(axes, f"With outliers: Laplace, mean size {config.scale_m:g} m", "reported minus true range [m]", "points")
