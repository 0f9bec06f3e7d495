"""Rain and spray: attenuation, and their echoes."""

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import (
    CAUSE_COLORS,
    SRX,
    cast,
    label,
    noise,
    one_unit,
    only_beam,
    outline,
    save,
    scene,
    sense,
    sheet,
)

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.rain import Rain, extinction
from luxloop.sensor_model.noise.spray import Spray
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Cause, Part
from luxloop.sim.scripted.motions import Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle
from luxloop.tracker.scan import PointFlag

RATES = (2.5, 10.0, 50.0)
SHADES = ("lightskyblue", "royalblue", "navy")
FRAMES = 200
SPEED_MPS = 28.0


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 3, 11.0, 4.0)
    _attenuation(panels[0, 0])
    _drops(panels[0, 1])
    _spray(panels[0, 2])
    save(figure, "weather")


def _attenuation(axes: Axes) -> None:
    """Draw the power of a plate's echo in rain relative to dry air."""
    ranges, rig, any_power = np.arange(10.0, 200.0, 10.0), one_unit(only_beam(0.0, 2)), np.array([1e-9])
    plates = [scene(street=(ScriptedObstacle([(r, -r), (r, r)], 20.0, kind="wall"),)) for r in ranges]
    dry = np.array([cast(plate, rig, threshold=any_power).echoes.power[0] for plate in plates])
    for rate, color in zip(RATES, SHADES, strict=True):
        air = extinction(Rain(enabled=True, rate_mm_per_h=rate))
        wet = [cast(plate, rig, threshold=any_power, extinction=air).echoes.power[0] for plate in plates]
        axes.plot(ranges, 10.0 * np.log10(wet / dry), color=color, label=f"{rate:g} mm/h")
    axes.set(xlim=(0.0, 200.0), ylim=(-7.0, 0.2))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(axes, "What rain leaves of an echo", "range [m]", "power against dry air [dB]")


def _drops(axes: Axes) -> None:
    """Draw the ranges of the echoes of drops, over many scans of an empty scene."""
    where, bins = scene(), np.arange(0.0, 20.01, 0.5)
    for rate, color in zip(RATES, SHADES, strict=True):
        config = noise(rain=Rain(enabled=True, rate_mm_per_h=rate))
        lidar = Lidar(SRX, config, SensorConfig(), 1, where.obstacles)
        truths = [lidar.scan(replace(where.frame, index=index))[1] for index in range(FRAMES)]
        ranges = np.concatenate([truth.true_range[truth.part == Part.DROPLET] for truth in truths])
        axes.hist(ranges, bins, weights=np.full(len(ranges), 1 / FRAMES), histtype="step", color=color, linewidth=1.6,
                  label=f"{rate:g} mm/h: {len(ranges) / FRAMES:.0f} a scan")  # fmt: skip
    axes.set(xlim=(0.0, 20.0))
    axes.legend(fontsize=8)
    label(axes, "Echoes of drops, six units", "range [m]", "drops a scan in 0.5 m")


def _spray(axes: Axes) -> None:
    """Draw the echoes of the spray of a car ahead on a wet motorway."""
    drive = [Straight("straight", speed_mps=SPEED_MPS)]
    cars = [ScriptedActor(x_m=x, y_m=y, reflectivity=0.4, motion=drive) for x, y in ((22.0, 0.0), (16.0, 3.6))]
    where = scene(*cars, ego=ScriptedEgo(motion=drive))
    scan, truth = sense(where, noise("mirror", "layer_overlap", spray=Spray(enabled=True)))
    outline(axes, where.frame)
    wet = truth.cause == Cause.SPRAY
    x, y, _ = scan.points_ego[~wet].T
    axes.scatter(x, y, s=4, color=CAUSE_COLORS[Cause.CLEAN], label="on the cars")
    known = (scan.flags & PointFlag.CLUTTER) > 0
    for own, marker, name in ((wet & ~known, "o", "spray"), (wet & known, "x", "spray, flagged by the unit")):
        x, y, _ = scan.points_ego[own].T
        axes.scatter(x, y, s=10, marker=marker, color=CAUSE_COLORS[Cause.SPRAY], linewidths=0.8,
                     label=f"{name} ({len(x)})")  # fmt: skip
    axes.set(xlim=(0.0, 26.0), ylim=(-9.0, 12.0), aspect="equal")
    axes.legend(fontsize=8, loc="lower left")
    label(axes, f"Two cars ahead at {SPEED_MPS:.0f} m/s on a wet road", "x forward [m]", "y left [m]")
