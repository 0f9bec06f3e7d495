"""Pitch of braking vehicles over time, and the beams of a braking ego on a car ahead, with and without pitch."""

import math
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.attitude import EGO_FRONT_M, LAYER_COLORS
from sensor_pictures.stage import Floats, label, one_unit, only_beam, save, scene, sense, sheet

from luxloop.sim.scripted.motions import Motion, Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo
from luxloop.sim.suspension import SPRUNG, Suspension
from luxloop.sim.world import Kind

BRAKING_MPS2 = 4.0
GAP_M = 20.0
HEIGHT_M = 0.55
FARTHEST_M = 60.0


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 2, 11.0, 4.2)
    _over_time(panels[0, 0])
    _beams(panels[0, 1])
    save(figure, "suspension")


def _over_time(axes: Axes) -> None:
    """Draw the pitch of a car, an SUV and a bus that brake from 12 m/s to a stop."""
    dt, speed = 0.02, 12.0
    time = np.arange(0.0, 6.0, dt)
    stop = 1.0 + speed / BRAKING_MPS2
    acceleration = np.interp(time, [1.0, 1.2, stop, stop + 0.1], [0.0, -BRAKING_MPS2, -BRAKING_MPS2, 0.0])
    for kind in (Kind.CAR, Kind.SUV, Kind.BUS):
        suspension = Suspension(dt)
        pitch = [
            suspension.attitude(np.array([0]), np.array([kind]), np.zeros(1), np.array([[now, 0.0]]))[0, 0]
            for now in acceleration
        ]
        settled = SPRUNG[kind].pitch_deg_per_g * BRAKING_MPS2 / 9.81
        axes.plot(time, np.degrees(pitch), label=f"{kind.name.lower()}, settled {settled:.2f} deg")
    axes.axvspan(1.0, stop, color="0.92", zorder=0)
    axes.set(xlim=(0.0, 6.0))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(axes, "Braking with 4 m/s² to a stop", "time [s]", "pitch [deg], nose down positive")


def _beams(axes: Axes) -> None:
    """Draw the layers straight ahead in a side view, dashed without pitch."""
    for layer, color in enumerate(LAYER_COLORS):
        for pitched in (False, True):
            x, z = _beam(layer, pitched=pitched)
            if pitched:
                axes.plot(x, z, color=color, label=f"layer {layer}", linewidth=1.6, marker="o", markevery=[1])
            else:
                axes.plot(x, z, color=color, linestyle="--", linewidth=1.0)
    rear = EGO_FRONT_M + GAP_M
    axes.fill([rear, rear, rear + 4.7, rear + 4.7], [0.2, 0.9, 0.9, 0.2], color="0.85", zorder=0)
    axes.plot([0.0, FARTHEST_M], [0.0, 0.0], color="0.3")
    axes.set(xlim=(0.0, 30.0), ylim=(-0.1, 1.3))
    axes.legend(fontsize=8, loc="upper left", ncols=2)
    label(axes, "LUX 0.55 m up; solid: the ego brakes with 4 m/s²; dashed: level", "ahead [m]", "height [m]")


def _beam(layer: int, *, pitched: bool) -> tuple[Floats, Floats]:
    """Return x and z of both ends of the central ray of a layer."""
    sensitive = replace(only_beam(0.0, layer), reference_reflectivity=1e-9, beam_height_deg=1e-3)
    motion: list[Motion] = [Straight("straight", speed_mps=15.0, acceleration_mps2=-BRAKING_MPS2)]
    car = ScriptedActor(x_m=EGO_FRONT_M + GAP_M + 2.35, y_m=0.0, reflectivity=0.4)
    where = scene(car, ego=ScriptedEgo(motion=motion))
    pitch = float(where.frame.ego.attitude[0])
    if not pitched:
        level = replace(where.frame.ego, attitude=np.zeros(2))
        where, pitch = replace(where, frame=replace(where.frame, ego=level)), 0.0
    _, truth = sense(where, rig=one_unit(sensitive, HEIGHT_M, x_m=EGO_FRONT_M))
    reach = float(truth.true_range[0]) if len(truth.true_range) else FARTHEST_M
    # A point (x, z) of the body is at x cos p + z sin p, z cos p - x sin p after a pitch p.
    cos, sin = math.cos(pitch), math.sin(pitch)
    down = pitch - math.radians(sensitive.layer_elevation_deg[layer])
    x, z = EGO_FRONT_M * cos + HEIGHT_M * sin, HEIGHT_M * cos - EGO_FRONT_M * sin
    return np.array([x, x + reach * math.cos(down)]), np.array([z, z - reach * math.sin(down)])
