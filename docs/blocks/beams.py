"""Draw the beams of the units: fields of view, mirror faces, sensitivity, and the six units of the rig in plan."""

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from luxloop.sensor_model.rig.beams import BeamTable, beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, Mount, Rig, load_rig, load_unit
from luxloop.sensor_model.rig.unit import UnitModel

PICTURE = Path(__file__).parents[1] / "pictures" / "sensor_beams.png"
LUX = load_unit("lux", SHIPPED)
LOWER, UPPER = "tab:blue", "tab:orange"
REACH_M = 30.0
AZIMUTH, ELEVATION = "azimuth [deg], left positive", "elevation [deg]"


def draw(_name: str) -> None:
    """Write the picture."""
    figure, panels = plt.subplots(2, 2, figsize=(11.0, 7.2), layout="constrained")
    for panel, axes in zip((_field_of_view, _mirror_sides, _gain, _rig), panels.flat, strict=True):
        panel(axes)
        axes.tick_params(labelsize=8)
    figure.savefig(PICTURE, dpi=95)
    plt.close(figure)


def beams_of(model: UnitModel) -> BeamTable:
    """Return the beams of one forward unit above the ego frame's x axis."""
    return beam_table(Rig(0.0, (Mount("only", model, 0.0, 0.0, 0.55, yaw_deg=0.0, pitch_deg=0.0, roll_deg=0.0),)))


def label(axes: Axes, title: str, x: str, y: str) -> None:
    """Set the title and the axis labels of a panel."""
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)


def _field_of_view(axes: Axes) -> None:
    """Draw the footprints of all beams of a LUX, and how the pairs interlace."""
    table = beams_of(LUX)
    azimuth, elevation = np.rad2deg(table.azimuth), np.rad2deg(table.elevation)
    half = 0.5 * LUX.beam_height_deg
    ends = [np.column_stack([azimuth, elevation + side]) for side in (-half, half)]
    footprints = np.stack(ends, axis=1)
    inset = axes.inset_axes((0.62, 0.72, 0.36, 0.26))
    for upper, color, name in ((False, LOWER, "lower pair (layers 0, 1)"), (True, UPPER, "upper pair (layers 2, 3)")):
        own = (table.layer >= 2) == upper
        axes.add_collection(LineCollection(footprints[own], colors=color, linewidths=0.6))
        axes.plot([], [], color=color, label=f"{name}: {own.sum()} beams")
        for x, y in zip(azimuth[own], elevation[own], strict=True):
            if abs(x) < 1.3:
                inset.plot([x, x], [y - half, y + half], color=color, linewidth=2)
    inset.set(xlim=(1.3, -1.3), ylim=(-1.7, 1.7), xticks=[1, 0.5, 0, -0.5, -1], yticks=[])
    inset.tick_params(labelsize=6)
    axes.set(xlim=(62, -62), ylim=(-1.8, 3.6))
    axes.legend(fontsize=8, loc="upper left")
    label(axes, f"LUX: {len(table)} beams a scan, each drawn as high as it is", AZIMUTH, ELEVATION)


def _mirror_sides(axes: Axes) -> None:
    """Draw the elevations of the layers of a LUX 8L over azimuth."""
    table = beams_of(load_unit("lux_8l", SHIPPED))
    for layer in range(8):
        own = table.layer == layer
        color, style = LOWER if layer % 4 < 2 else UPPER, "-" if layer < 4 else "--"
        azimuth, elevation = np.rad2deg(table.azimuth[own]), np.rad2deg(table.elevation[own])
        axes.plot(azimuth, elevation, color=color, linestyle=style, linewidth=1.4)
    for style, name in (("-", "front side, even frames"), ("--", "rear side, odd frames")):
        axes.plot([], [], "k", linestyle=style, label=name)
    axes.set(xlim=(62, -62))
    axes.legend(fontsize=8, loc="upper left")
    label(axes, "LUX 8L: the two sides of its mirror, in turn", AZIMUTH, ELEVATION)


def _gain(axes: Axes) -> None:
    """Draw the sensitivity of every beam, and its knots."""
    table = beams_of(LUX)
    for layer, color, name in ((0, LOWER, "lower pair"), (2, UPPER, "upper pair")):
        own = table.layer == layer
        axes.plot(np.rad2deg(table.azimuth[own]), table.gain[own], color=color, label=name)
    knots = np.array(LUX.gain_azimuth_deg)
    for fan, color in zip(LUX.fans, (LOWER, UPPER), strict=True):
        inside = (knots <= fan.start_deg) & (knots >= fan.stop_deg)
        axes.plot(knots[inside], np.array(fan.gain_percent)[inside] / 100.0, "o", color=color, markersize=3.5)
    axes.set(xlim=(62, -62), ylim=(0.0, 1.1))
    axes.legend(fontsize=8, loc="lower center")
    axes.grid(alpha=0.3)
    label(axes, "LUX: sensitivity g over azimuth (dots: knots)", AZIMUTH, "gain g [1]")


def _rig(axes: Axes) -> None:
    """Draw the fields of view of the six units in plan."""
    rig = load_rig("srx_six_lux", SHIPPED)
    table = beam_table(rig)
    for unit, mount in enumerate(rig.mounts):
        color = f"C{unit}"
        origin = table.units.origin_ego[unit, :2]
        for lowest, strength in ((0, 0.16), (2, 0.30)):
            own = (table.unit == unit) & (table.layer == lowest)
            rim = origin + REACH_M * table.direction_ego[own, :2]
            axes.add_patch(Polygon(np.vstack([origin, rim]), color=color, alpha=strength, linewidth=0))
        x, y = origin + 0.55 * REACH_M * table.units.R_ego_unit[unit, :2, 0]
        style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8, "fontweight": "bold"}
        axes.text(x, y, mount.name.replace(" ", "\n"), color=color, **style)
    axes.add_patch(Polygon([(2.415, 0.955), (-2.415, 0.955), (-2.415, -0.955), (2.415, -0.955)], color="black"))
    axes.set(xlim=(-33, 33), ylim=(-33, 33), aspect="equal")
    title = "Six LUX around the ego, out to 30 m\n(dark: upper pair, light: lower pair)"
    label(axes, title, "x forward [m]", "y left [m]")
