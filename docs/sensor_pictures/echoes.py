"""Echo detection: power that returns to single beams within a pulse length, threshold, and reported echoes."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import (
    PART_COLORS,
    Cast,
    Floats,
    Scene,
    cast,
    label,
    one_unit,
    only_beam,
    rays_of,
    save,
    scene,
    sheet,
)

from luxloop.sensor_model.rig.unit import UnitModel
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Part
from luxloop.sim.scripted.script import ScriptedActor, ScriptedObstacle

EDGE_DEG = 3.4
"""Azimuth of a car's edge, 15 m away."""
FOOTPRINT = SensorConfig().footprint
STEP_M = 0.002
NAMES = {Part.OBSTACLE: "wall", Part.BODY: "body", Part.GREENHOUSE: "pane", Part.INTERIOR: "interior"}


@dataclass(frozen=True)
class Case:
    """A beam and its scene."""

    title: str
    where: Scene
    beam: UnitModel
    z_m: float = 0.55
    """Height of the unit."""


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(2, 3, 11.0, 6.4)
    for axes, case in zip(panels.flat, _cases(), strict=True):
        _panel(axes, case)
    for part, name in NAMES.items():
        panels[0, 0].fill_between([], [], color=PART_COLORS[part], label=name)
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), fontsize=9, frameon=False)
    save(figure, "echoes")


def _cases() -> list[Case]:
    upper, top = only_beam(0.0, 2), only_beam(0.0, 3)
    return [
        Case("a wall: one echo", scene(street=(_wall(15.0),)), upper),
        Case(
            "half on a car's edge, half on a wall:\ntwo echoes",
            scene(_car(15.0), street=(_wall(22.0),)),
            only_beam(EDGE_DEG, 2),
        ),
        Case(
            "two walls 1 m apart: one echo, as they\nare nearer than the echo separation",
            scene(street=(_wall(15.0, height_m=0.66), _wall(16.0))),
            upper,
        ),
        Case("a deck and the rear window behind it:\none echo, at the deck", scene(_car(20.0)), top),
        Case(
            "a bus's windscreen at 12 m, from 1.5 m up:\none echo, at the pane", scene(_oncoming(12.0)), upper, z_m=1.5
        ),
        Case(
            "the same at 42 m: the pane is too weak,\nthe echo is that of the interior",
            scene(_oncoming(42.0)),
            upper,
            z_m=1.5,
        ),
    ]


def _wall(x_m: float, height_m: float = 4.0) -> ScriptedObstacle:
    return ScriptedObstacle([(x_m, -20.0), (x_m, 20.0)], height_m=height_m, kind="wall")


def _car(rear_m: float) -> ScriptedActor:
    return ScriptedActor(x_m=rear_m + 2.35, y_m=0.0, reflectivity=0.4)


def _oncoming(front_m: float) -> ScriptedActor:
    """Return a bus, whose windscreen begins low, seen from the front."""
    return ScriptedActor(x_m=front_m + 6.0, y_m=0.0, yaw_deg=180.0, kind="bus", reflectivity=0.4)


def _panel(axes: Axes, case: Case) -> None:
    """Draw the power summed within a pulse length, by source, and the reported echoes."""
    rays = cast(case.where, one_unit(rays_of(case.beam, FOOTPRINT), case.z_m), SensorConfig(footprint=(1, 1)))
    whole = cast(case.where, one_unit(case.beam, case.z_m))
    threshold, pulse = whole.beams.units.threshold[0], whole.beams.units.pulse_length[0]
    nearest, farthest = rays.echoes.range.min(), rays.echoes.range.max()
    at = np.arange(nearest - 0.3, farthest + pulse + 0.7, STEP_M)
    below = np.zeros(len(at))
    for part, color in PART_COLORS.items():
        above = below + _summed(rays, rays.part == part, at, pulse) / threshold
        if np.any(above > below):
            axes.fill_between(at, below, above, color=color, alpha=0.75, linewidth=0)
        below = above
    axes.axhline(1.0, color="black", linestyle="--", linewidth=1.0)
    high = 1.5 * max(below.max(), 1.6)
    for range_, width in zip(whole.echoes.range, whole.echoes.width, strict=True):
        axes.plot([range_, range_ + width], [0.81 * high] * 2, color="tab:red", linewidth=2.5, solid_capstyle="butt")
        axes.plot(range_, 0.81 * high, marker="v", color="tab:red", markersize=7)
        axes.text(range_, 0.85 * high, f"{range_:.2f} m\nwidth {width:.2f} m", color="tab:red", fontsize=8)
    axes.set(ylim=(0.0, high), xlim=(at[0], max(at[-1], at[0] + 2.4)))
    label(axes, case.title, "range [m]", "power / threshold [1]")


def _summed(rays: Cast, own: Floats, at: Floats, pulse: float) -> Floats:
    """Return the power at each range `at` of the rays' echoes in `own`: all within one pulse length before [1/m^2]."""
    range_, power = rays.echoes.range[own], rays.echoes.power[own] / (FOOTPRINT[0] * FOOTPRINT[1])
    within = (range_[:, None] <= at) & (at < range_[:, None] + pulse)
    summed: Floats = power @ within
    return summed
