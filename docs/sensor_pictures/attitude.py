"""Effects of pitch and mounting height: attitude over time, ground echoes, and layers above a car's deck."""

from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import SRX, cast, label, noise, one_unit, only_beam, save, scene, sense, sheet

from luxloop.sensor_model.noise.attitude import Attitude, AttitudeNoise
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.truth import Cause
from luxloop.sim.scripted.script import ScriptedActor
from luxloop.sim.world import Kind

LAYER_COLORS = ("tab:blue", "deepskyblue", "gold", "tab:orange")
EGO_FRONT_M = 4.83 / 2.0
GAPS_M = np.arange(5.0, 45.1, 1.0)
OFF = noise("mirror", "layer_overlap")


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(2, 2, 11.0, 7.0)
    _over_time(panels[0, 0])
    _ground(panels[0, 1])
    _overlap(panels[1, 0])
    _side(panels[1, 1])
    save(figure, "attitude")


def _over_time(axes: Axes) -> None:
    """Draw pitch and roll of an ego on an ordinary road, and their spectrum."""
    config = AttitudeNoise(enabled=True)
    attitude = Attitude(config, Draws(1, beam_table(SRX)))
    time = np.arange(0.0, 10.0, 0.02)
    R = np.array([attitude.at(t, speed=20.0) for t in time])
    pitch, roll = np.rad2deg(np.arcsin(-R[:, 2, 0])), np.rad2deg(np.arctan2(R[:, 2, 1], R[:, 2, 2]))
    axes.plot(time, pitch, color="tab:blue", label="pitch (nose down positive)")
    axes.plot(time, roll, color="tab:orange", label="roll (right side down positive)", linewidth=1)
    axes.axhspan(-config.pitch_sigma_deg, config.pitch_sigma_deg, color="0.9", zorder=0, label="one standard deviation")
    axes.set(xlim=(0, 10), ylim=(-1.8, 2.6))
    axes.legend(fontsize=8, loc="upper right", ncols=2)
    label(axes, "Attitude of the ego's body, with attitude noise on", "time [s]", "angle [deg]")


def _ground(axes: Axes) -> None:
    """Draw the ranges at which the beams straight ahead hit a flat road, and which of them give an echo."""
    pitches = np.arange(-1.5, 4.01, 0.1)
    for layer, color in enumerate(LAYER_COLORS):
        met, seen = np.full((2, len(pitches)), np.nan)
        for row, pitch in enumerate(pitches):
            rig = one_unit(only_beam(0.0, layer), pitch_deg=pitch)
            echoes = cast(scene(), rig).echoes
            met[row] = cast(scene(), rig, threshold=np.array([1e-9])).echoes.range.min(initial=200.0)
            seen[row] = echoes.range[0] if len(echoes.range) else np.nan
        axes.plot(pitches, met, color=color, linewidth=1.0, label=f"layer {layer}")
        axes.plot(pitches, seen, color=color, linewidth=4.0, alpha=0.8)
    axes.plot([], [], color="0.4", linewidth=4.0, label="enough for an echo")
    axes.set(xlim=(-1.5, 4.0), ylim=(0.0, 60.0))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(
        axes, "Flat road before a LUX 0.55 m up", "pitch [deg], nose down positive", "nearest part of the footprint [m]"
    )


def _overlap(axes: Axes) -> None:
    """Draw the share of a car's points on its window, well inside its outline."""
    for height, color in ((0.55, "tab:blue"), (0.80, "tab:orange")):
        for pitch, style in ((0.0, "-"), (-1.0, "--"), (1.0, ":")):
            shares = [_share_inside(_at_height(height), pitch, gap) for gap in GAPS_M]
            name = f"units {height:.2f} m up, pitch {pitch:+.0f} deg"
            axes.plot(GAPS_M, shares, color=color, linestyle=style, label=name)
    axes.set(xlim=(GAPS_M[0], GAPS_M[-1]), ylim=(0.0, 0.75))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2, loc="upper right")
    label(axes, "Layer overlap: points inside the outline of a car ahead", "gap [m]", "share of its points [1]")


def _at_height(z_m: float) -> Rig:
    """Return the rig with all units at one height."""
    return replace(SRX, mounts=tuple(replace(mount, z_m=z_m) for mount in SRX.mounts))


def _share_inside(rig: Rig, pitch_deg: float, gap_m: float) -> float:
    level = AttitudeNoise(enabled=True, pitch_deg=pitch_deg, pitch_sigma_deg=0.0, roll_sigma_deg=0.0)
    _, truth = sense(scene(_car(gap_m)), replace(OFF, attitude=level), rig=rig)
    own = truth.actor_id >= 0
    return float(np.mean(truth.cause[own] == Cause.LAYER_OVERLAP)) if own.any() else np.nan


def _car(gap_m: float) -> ScriptedActor:
    return ScriptedActor(x_m=EGO_FRONT_M + gap_m + 2.35, y_m=0.0, kind=Kind.CAR.name.lower(), reflectivity=0.4)


def _side(axes: Axes) -> None:
    """Draw the points on a car 25 m ahead, by layer, in plan."""
    rig = _at_height(0.80)
    for row, pitch in enumerate((-1.0, 0.0, 1.0)):
        level = AttitudeNoise(enabled=True, pitch_deg=pitch, pitch_sigma_deg=0.0, roll_sigma_deg=0.0)
        scan, truth = sense(scene(_car(25.0)), replace(OFF, attitude=level), rig=rig)
        own = truth.actor_id >= 0
        behind = scan.points_ego[own, 0] - EGO_FRONT_M - 25.0
        for layer in range(4):
            layered = scan.layer[own] == layer
            height = np.full(np.count_nonzero(layered), row + 0.12 * (layer - 1.5))
            name = f"layer {layer}" if row == 0 else None
            axes.scatter(behind[layered], height, s=12, color=LAYER_COLORS[layer], label=name)
    axes.set(ylim=(-0.6, 2.9), yticks=range(3), yticklabels=("pitch -1 deg\n(nose up)", "level", "pitch +1 deg"))
    axes.axvspan(0.0, 0.2, color="0.92", zorder=0)
    axes.legend(fontsize=8, loc="upper right", ncols=4)
    label(axes, "How deep the layers see a car 25 m ahead, units 0.80 m up", "depth behind its rear [m]", "")
