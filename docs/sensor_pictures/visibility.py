"""Visible fraction of a car while a van occludes it, for all units and for each."""

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import SRX, Scene, label, outline, save, scene, sense, sheet

from luxloop.sim.scripted.script import ScriptedActor

HIDDEN, HIDING = 0, 1
"""Rows of the actors."""
SHOWN_Y_M = -1.2
"""Position of the occluding van in the first panel."""


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 3, 11.0, 3.9)
    _snapshot(panels[0, 0])
    _slide(panels[0, 1], panels[0, 2])
    save(figure, "visibility")


def _where(y_m: float) -> Scene:
    car = ScriptedActor(x_m=30.0, y_m=0.0, yaw_deg=20.0, reflectivity=0.4)
    van = ScriptedActor(x_m=15.0, y_m=y_m, kind="van", reflectivity=0.4)
    return scene(car, van)


def _snapshot(axes: Axes) -> None:
    where = _where(SHOWN_Y_M)
    scan, truth = sense(where)
    outline(axes, where.frame)
    for row, color, name in ((HIDDEN, "tab:blue", "car"), (HIDING, "0.4", "van")):
        own = truth.actor_id == where.frame.actors.id[row]
        x, y, _ = scan.points_ego[own].T
        axes.scatter(x, y, s=5, color=color, label=f"{name}: visible {truth.visible_fraction[row]:.0%}")
    axes.plot([2.4, 2.4, 0, 0, 2.4], [-0.95, 0.95, 0.95, -0.95, -0.95], color="black")
    axes.set(xlim=(0.0, 34.0), ylim=(-6.5, 9.5), aspect="equal")
    axes.legend(fontsize=8, loc="upper left")
    label(axes, f"The van at y = {SHOWN_Y_M:g} m", "x forward [m]", "y left [m]")


def _slide(whole: Axes, units: Axes) -> None:
    places = np.arange(-6.0, 6.01, 0.1)
    fraction, points = np.empty(len(places)), np.empty(len(places))
    hits, alone = np.empty((2, len(places), len(SRX.mounts)))
    for row, y_m in enumerate(places):
        scene_ = _where(y_m)
        _, truth = sense(scene_)
        fraction[row] = truth.visible_fraction[HIDDEN]
        points[row] = np.count_nonzero(truth.actor_id == scene_.frame.actors.id[HIDDEN])
        hits[row], alone[row] = truth.unit_hits[HIDDEN], truth.unit_hits_alone[HIDDEN]
    whole.plot(places, fraction, color="tab:blue", label="visible fraction")
    whole.plot(places, points / points.max(), color="0.6", linewidth=1.0, label=f"points / {points.max():.0f}")
    whole.axvline(SHOWN_Y_M, color="black", linewidth=0.7, linestyle=":")
    whole.set(xlim=(-6.0, 6.0), ylim=(0.0, 1.08))
    whole.legend(fontsize=8, loc="lower right")
    label(whole, "The car, while the van slides past", "y of the van [m]", "share [1]")
    for unit, color in ((0, "tab:blue"), (1, "tab:orange")):
        units.plot(places, hits[:, unit], color=color, label=f"{SRX.mounts[unit].name} unit")
        units.plot(places, alone[:, unit], color=color, linestyle="--", label="if the car were alone")
    units.set(xlim=(-6.0, 6.0), ylim=(0.0, 1.55 * alone.max()))
    units.legend(fontsize=8, loc="upper right")
    label(units, "Rays of each front unit that end on the car", "y of the van [m]", "rays")
