"""Draw the beams of the units: fields of view, sensitivity, and the six units of the rig in plan."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from luxloop.sensor_model.rig.beams import BeamTable, beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, Mount, Rig, load_rig, load_unit

PICTURE = Path(__file__).parents[1] / "pictures" / "sensor_beams.png"
LUX = load_unit("lux", SHIPPED)
FORWARD = Rig(0.0, (Mount("only", LUX, 0.0, 0.0, 0.55, yaw_deg=0.0, pitch_deg=0.0, roll_deg=0.0),))
"""Rig of one unit that looks along the x axis of the ego."""
PAIRS = ((0, "tab:blue", "lower pair (layers 0, 1)"), (2, "tab:orange", "upper pair (layers 2, 3)"))
"""Lowest layer, colour and name."""
REACH_M = 30.0


def draw(_name: str) -> None:
    """Write the picture."""
    figure = plt.figure(figsize=(11.0, 5.6), layout="constrained")
    plan, beams, gain = figure.subplot_mosaic("RF;RG", width_ratios=(1, 1.1)).values()
    field_of_view(beams, beam_table(FORWARD))
    sensitivity(gain, beam_table(FORWARD))
    rig(plan)
    figure.savefig(PICTURE, dpi=95)


def field_of_view(axes: Axes, table: BeamTable) -> None:
    """Draw the footprints of all beams of a LUX."""
    azimuth, elevation = np.rad2deg(table.azimuth), np.rad2deg(table.elevation)
    half = 0.5 * LUX.beam_height_deg
    footprints = np.stack([np.column_stack([azimuth, elevation + side]) for side in (-half, half)], axis=1)
    for lowest, color, name in PAIRS:
        own = (table.layer // 2 * 2) == lowest
        axes.add_collection(LineCollection(footprints[own], colors=color, linewidths=0.6))
        axes.plot([], [], color=color, label=f"{name}: {own.sum()} beams")
    axes.set(xlim=(62, -62), ylim=(-1.8, 3.0), ylabel="elevation [deg]")
    axes.set_title(f"LUX: {len(table)} beams a scan, each drawn as high as it is", fontsize=10)
    axes.legend(fontsize=8, loc="upper left")


def sensitivity(axes: Axes, table: BeamTable) -> None:
    """Draw the sensitivity of every beam, and its knots."""
    knots = np.array(LUX.gain_azimuth_deg)
    for fan, (lowest, color, _) in zip(LUX.fans, PAIRS, strict=True):
        own = table.layer == lowest
        axes.plot(np.rad2deg(table.azimuth[own]), table.gain[own], color=color)
        inside = (knots <= fan.start_deg) & (knots >= fan.stop_deg)
        axes.plot(knots[inside], np.array(fan.gain_percent)[inside] / 100.0, "o", color=color, markersize=3.5)
    axes.set(xlim=(62, -62), ylim=(0.0, 1.1), xlabel="azimuth [deg], left positive", ylabel="gain g [1]")
    axes.set_title("LUX: sensitivity g over azimuth (dots: knots)", fontsize=10)
    axes.grid(alpha=0.3)


def rig(axes: Axes) -> None:
    """Draw the fields of view of the six units in plan."""
    six = load_rig("srx_six_lux", SHIPPED)
    table = beam_table(six)
    for unit, mount in enumerate(six.mounts):
        origin = table.units.origin_ego[unit, :2]
        for (lowest, _, _), strength in zip(PAIRS, (0.16, 0.30), strict=True):
            own = (table.unit == unit) & (table.layer == lowest)
            rim = origin + REACH_M * table.direction_ego[own, :2]
            axes.add_patch(Polygon(np.vstack([origin, rim]), color=f"C{unit}", alpha=strength, linewidth=0))
        at = origin + 0.55 * REACH_M * table.units.R_ego_unit[unit, :2, 0]
        axes.text(*at, mount.name.replace(" ", "\n"), color=f"C{unit}", ha="center", va="center", weight="bold")
    axes.add_patch(Polygon([(2.415, 0.955), (-2.415, 0.955), (-2.415, -0.955), (2.415, -0.955)], color="black"))
    axes.set(xlim=(-33, 33), ylim=(-33, 33), aspect="equal", xlabel="x forward [m]", ylabel="y left [m]")
    axes.set_title("Six LUX around the ego, out to 30 m\n(dark: upper pair, light: lower pair)", fontsize=10)
