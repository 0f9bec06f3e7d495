"""Detection: power against range for paints, angle of incidence, and soft threshold."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import LUX, Scene, cast, label, noise, one_unit, only_beam, save, scene, sense, sheet

from luxloop.sensor_model.noise.dropout import Dropout
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.rig.unit import Fan
from luxloop.sensor_model.truth import Part
from luxloop.sim.scripted.script import ScriptedObstacle

PAINTS = {"black": 0.04, "dark metallic": 0.1, "silver": 0.4, "white": 0.7}
COLORS = {"black": "black", "dark metallic": "tab:brown", "silver": "tab:blue", "white": "goldenrod"}
RANGES_M = np.concatenate([np.arange(4.0, 20.0, 1.0), np.arange(20.0, 160.0, 2.0)])
BEAMS = 2001
"""Number of beams of the unit that counts returning beams."""


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 3, 11.0, 3.9)
    _power(panels[0, 0])
    _returns(panels[0, 1])
    _angle(panels[0, 2])
    save(figure, "power")


def _power(axes: Axes) -> None:
    """Draw the power of the echo of a plate at normal incidence."""
    rig = one_unit(only_beam(0.0, 2))
    for paint, reflectivity in PAINTS.items():
        ratio = [_power_over_threshold(_plate(range_m, reflectivity), rig) for range_m in RANGES_M]
        axes.plot(RANGES_M, 10.0 * np.log10(ratio), color=COLORS[paint], label=f"{paint} ({reflectivity:g})")
    half = Dropout().softness_db / 2.0
    axes.axhspan(-half, half, color="tab:red", alpha=0.3, label="threshold, 10 to 90 % seen")
    axes.set(xscale="log", xlim=(4.0, 160.0), ylim=(-15.0, 38.0), xticks=[5, 10, 20, 50, 100])
    axes.xaxis.set_major_formatter(plt.ScalarFormatter())
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7.5)
    label(axes, "Power of a plate that faces the unit", "range [m]", "power over threshold [dB]")


def _power_over_threshold(where: Scene, rig: Rig) -> float:
    """Return the power that returns to the only beam of a rig, detected or not, over its threshold."""
    echoes = cast(where, rig).echoes
    power = echoes.power if len(echoes.power) else echoes.lost_power
    return float(power[0] / rig_threshold(rig))


def rig_threshold(rig: Rig) -> float:
    """Return the threshold of the rig's unit [1/m^2]."""
    model = rig.mounts[0].model
    return model.reference_reflectivity / model.reference_range_m**2


def _plate(range_m: float, reflectivity: float) -> Scene:
    half = 20.0 + range_m
    return scene(
        street=(ScriptedObstacle([(range_m, -half), (range_m, half)], 20.0, kind="wall", reflectivity=reflectivity),)
    )


def _returns(axes: Axes) -> None:
    """Draw the share of returning beams on a plate, counted with a unit of many beams straight ahead."""
    fan = Fan((0,), start_deg=0.1, stop_deg=-0.1, step_deg=0.2 / (BEAMS - 1), gain_percent=(100.0,))
    model = replace(
        LUX,
        layer_elevation_deg=(0.4,),
        layer_bias_m=(0.0,),
        layer_pulse_bias_m=(0.0,),
        gain_azimuth_deg=(0.0,),
        fans=(fan,),
        beam_width_deg=1e-4,
    )
    for paint, reflectivity in PAINTS.items():
        seen = [_share(one_unit(model), _plate(range_m, reflectivity)) for range_m in RANGES_M]
        axes.plot(RANGES_M, seen, color=COLORS[paint], label=f"{paint} ({reflectivity:g})")
    axes.axhline(1.0 - Dropout().random_rate, color="0.4", linestyle=":", linewidth=1)
    axes.text(2.0, 1.015, "random floor", fontsize=7.5, color="0.4")
    axes.set(xlim=(0.0, 160.0), ylim=(0.0, 1.07))
    axes.grid(alpha=0.3)
    label(axes, "Share of beams that return, with dropout on", "range [m]", "share of beams [1]")


def _share(rig: Rig, where: Scene) -> float:
    _, truth = sense(where, noise("dropout"), rig=rig)
    return int(np.count_nonzero(truth.part == Part.OBSTACLE)) / BEAMS


def _angle(axes: Axes) -> None:
    """Draw the detection range of a plate over the angle of incidence."""
    turned_deg = np.arange(0.0, 90.0, 3.0)
    for paint, reflectivity in PAINTS.items():
        axes.plot(turned_deg, [_farthest(reflectivity, angle) for angle in turned_deg], color=COLORS[paint])
    axes.set(xlim=(0.0, 90.0), ylim=(0.0, 145.0), xticks=[0, 30, 60, 90])
    axes.grid(alpha=0.3)
    label(axes, "How far a turned plate is seen", "angle of incidence [deg]", "range at the threshold [m]")


def _farthest(reflectivity: float, angle_deg: float) -> float:
    """Return the range at which a plate just reaches the threshold [m]; power falls with the square of the range."""
    at_m = 10.0
    along = 30.0 * np.array([-np.sin(np.deg2rad(angle_deg)), np.cos(np.deg2rad(angle_deg))])
    ends = [(at_m + side * along[0], side * along[1]) for side in (-1.0, 1.0)]
    wall = ScriptedObstacle(ends, 20.0, kind="wall", reflectivity=reflectivity)
    narrow = one_unit(replace(only_beam(0.0, 2), beam_width_deg=1e-3))
    return at_m * np.sqrt(_power_over_threshold(scene(street=(wall,)), narrow))
