"""Beams: field of view of a unit, mirror faces, sensitivity, and the six units in plan."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon
from sensor_pictures.stage import LOWER, LUX, SRX, UPPER, Floats, label, one_unit, save, sheet

from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, load_unit

REACH_M = 30.0


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(2, 2, 11.0, 7.2)
    _field_of_view(panels[0, 0])
    _mirror_sides(panels[0, 1])
    _gain(panels[1, 0])
    _rig(panels[1, 1])
    save(figure, "beams")


def _field_of_view(axes: Axes) -> None:
    """Draw the footprints of all beams of a LUX."""
    table = beam_table(one_unit(LUX))
    azimuth, elevation = np.rad2deg(table.azimuth), np.rad2deg(table.elevation)
    half_m = 0.5 * LUX.beam_height_deg
    for upper, color in ((False, LOWER), (True, UPPER)):
        own = (table.layer >= 2) == upper
        ends = np.stack(
            [np.column_stack([azimuth, elevation - half_m]), np.column_stack([azimuth, elevation + half_m])]
        )
        axes.add_collection(LineCollection(ends[:, own].transpose(1, 0, 2), colors=color, linewidths=0.6))
        name = "upper pair (layers 2, 3)" if upper else "lower pair (layers 0, 1)"
        axes.plot([], [], color=color, label=f"{name}: {own.sum()} beams")
    axes.set(xlim=(62, -62), ylim=(-1.8, 3.6))
    axes.legend(fontsize=8, loc="upper left")
    inset = axes.inset_axes((0.62, 0.72, 0.36, 0.26))
    near = np.abs(azimuth) < 1.3
    colors = np.where(table.layer[near] >= 2, UPPER, LOWER)
    for x, y, color in zip(azimuth[near], elevation[near], colors, strict=True):
        inset.plot([x, x], [y - half_m, y + half_m], color=color, linewidth=2)
    inset.set(xlim=(1.3, -1.3), ylim=(-1.7, 1.7), xticks=[1, 0.5, 0, -0.5, -1], yticks=[])
    inset.tick_params(labelsize=6)
    label(axes, f"LUX: {len(table)} beams a scan, each drawn as high as it is", "azimuth [deg], left positive",
          "elevation [deg]")  # fmt: skip


def _mirror_sides(axes: Axes) -> None:
    """Draw the elevations of the layers of a LUX 8L over azimuth."""
    model = load_unit("lux_8l", SHIPPED)
    table = beam_table(one_unit(model))
    azimuth, elevation = np.rad2deg(table.azimuth), np.rad2deg(table.elevation)
    for layer in range(8):
        own = table.layer == layer
        color = LOWER if layer % 4 < 2 else UPPER
        axes.plot(azimuth[own], elevation[own], color=color, linestyle="-" if layer < 4 else "--", linewidth=1.4)
    for style, name in (("-", "front side, even frames"), ("--", "rear side, odd frames")):
        axes.plot([], [], "k", linestyle=style, label=name)
    axes.set(xlim=(62, -62))
    axes.legend(fontsize=8, loc="upper left")
    label(axes, "LUX 8L: the two sides of its mirror, in turn", "azimuth [deg], left positive", "elevation [deg]")


def _gain(axes: Axes) -> None:
    """Draw the sensitivity of every beam, and its knots."""
    table = beam_table(one_unit(LUX))
    azimuth = np.rad2deg(table.azimuth)
    for layer, color, name in ((0, LOWER, "lower pair"), (2, UPPER, "upper pair")):
        own = table.layer == layer
        axes.plot(azimuth[own], table.gain[own], color=color, label=name)
    for fan, color in zip(LUX.fans, (LOWER, UPPER), strict=True):
        inside = (np.array(LUX.gain_azimuth_deg) <= fan.start_deg) & (np.array(LUX.gain_azimuth_deg) >= fan.stop_deg)
        axes.plot(np.array(LUX.gain_azimuth_deg)[inside], np.array(fan.gain_percent)[inside] / 100.0, "o",
                  color=color, markersize=3.5)  # fmt: skip
    axes.set(xlim=(62, -62), ylim=(0.0, 1.1))
    axes.legend(fontsize=8, loc="lower center")
    axes.grid(alpha=0.3)
    label(axes, "LUX: sensitivity g over azimuth (dots: knots)", "azimuth [deg], left positive", "gain g [1]")


def _rig(axes: Axes) -> None:
    """Draw the fields of view of the six units in plan."""
    table = beam_table(SRX)
    colors = plt.get_cmap("tab10").colors
    for unit, mount in enumerate(SRX.mounts):
        x, y, _ = table.units.origin_ego[unit]
        for lowest, strength in ((0, 0.16), (2, 0.30)):
            own = (table.unit == unit) & (table.layer == lowest)
            rim = table.units.origin_ego[unit, :2] + REACH_M * table.direction_ego[own, :2]
            axes.add_patch(Polygon(np.vstack([(x, y), rim]), color=colors[unit], alpha=strength, linewidth=0))
        towards: Floats = table.units.R_ego_unit[unit] @ (0.55 * REACH_M, 0.0, 0.0)
        axes.text(x + towards[0], y + towards[1], mount.name.replace(" ", "\n"), color=colors[unit], ha="center",
                  va="center", fontsize=8, fontweight="bold")  # fmt: skip
    axes.add_patch(Polygon([(2.415, 0.955), (-2.415, 0.955), (-2.415, -0.955), (2.415, -0.955)], color="black"))
    axes.set(xlim=(-33, 33), ylim=(-33, 33), aspect="equal")
    label(axes, "Six LUX around the ego, out to 30 m\n(dark: upper pair, light: lower pair)", "x forward [m]",
          "y left [m]")  # fmt: skip
