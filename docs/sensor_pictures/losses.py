"""Lost beams: outages over time, dirty and sunlit sectors, and causes in one scan."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import LUX, SRX, Scene, cast, label, noise, one_unit, save, scene, sense

from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.dirt import Dirt
from luxloop.sensor_model.noise.dropout import Dropout
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.outage import FixedOutage, Outage, Outages
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.sun import Sun
from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Loss, Part
from luxloop.sim.scripted.script import ScriptedActor, ScriptedObstacle

LOSS_COLORS = {
    Loss.THRESHOLD: "0.75",
    Loss.RANDOM: "black",
    Loss.OUTAGE: "tab:red",
    Loss.DIRT: "tab:brown",
    Loss.SUN: "goldenrod",
    Loss.AIR: "royalblue",
}
SUN_DEG = 30.0


def draw() -> None:
    """Write the picture."""
    figure, panels = plt.subplot_mosaic("AB;CC", figsize=(11.0, 7.0), layout="constrained")
    _outages(panels["A"])
    _sectors(panels["B"])
    _causes(panels["C"])
    save(figure, "losses")


def _outages(axes: Axes) -> None:
    """Draw the outages of each unit of the rig."""
    names = [mount.name for mount in SRX.mounts]
    config = Outage(enabled=True)
    outages = Outages(config, Draws(1, beam_table(SRX)), names)
    time = np.arange(0.0, 600.0, 0.08)
    silent = np.array([outages.silent(t) for t in time])
    for unit in range(len(names)):
        axes.fill_between(
            time,
            unit - 0.35,
            unit + 0.35,
            where=silent[:, unit],
            color=LOSS_COLORS[Loss.OUTAGE],
            edgecolor=LOSS_COLORS[Loss.OUTAGE],
            linewidth=1.0,
        )
        axes.axhline(unit, color="0.85", zorder=0)
    axes.set(xlim=(0.0, 600.0), ylim=(5.6, -0.6), yticks=range(6), yticklabels=names)
    label(
        axes,
        f"Silent units: up for {config.mean_uptime_s:g} s on the mean,\nthen out for {config.mean_outage_s:g} s",
        "time [s]",
        "",
    )


def _sectors(axes: Axes) -> None:
    """Draw the detection range of a grey surface with dirt, and with sun glare."""
    kinds = {
        "clean and shaded": noise(),
        "dirt": noise(dirt=Dirt(enabled=True)),
        "sun": noise(sun=Sun(enabled=True, azimuth_deg=SUN_DEG)),
    }
    colors = ("black", LOSS_COLORS[Loss.DIRT], LOSS_COLORS[Loss.SUN])
    for (name, config), color in zip(kinds.items(), colors, strict=True):
        azimuth, farthest = _reach(config)
        axes.plot(azimuth, farthest, color=color, label=name, linewidth=1.6)
    axes.set(xlim=(62, -62), ylim=(0.0, 62.0))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="lower center")
    label(
        axes,
        "How far the lower pair of a LUX sees\na surface of reflectivity 0.1",
        "azimuth [deg], left positive",
        "range [m]",
    )


def _reach(config: NoiseConfig) -> tuple[np.ndarray, np.ndarray]:
    """Return azimuths [deg] of the beams of layer 1, and their detection ranges for a wall at normal incidence [m]."""
    rig = one_unit(LUX, z_m=2.0)
    beams = beam_table(rig)
    azimuth = np.rad2deg(beams.azimuth[beams.layer == 1])
    farthest = np.zeros(len(azimuth))
    for range_m in np.arange(5.0, 60.1, 0.5):
        angle = np.deg2rad(np.arange(0.0, 360.0, 1.0))
        corners = [(range_m * np.cos(a), range_m * np.sin(a)) for a in angle]
        round_wall = ScriptedObstacle(corners, 20.0, reflectivity=0.1)
        scan, truth = sense(scene(street=(round_wall,)), config, rig=rig)
        own = (scan.layer == 1) & (truth.part == Part.OBSTACLE)
        x, y, _ = scan.points_ego[own].T
        farthest[np.abs(np.rad2deg(np.arctan2(y, x))[:, None] - azimuth).argmin(axis=1)] = range_m
    return azimuth, farthest


def _causes(axes: Axes) -> None:
    """Draw the lost beams of one scan at their ends, by cause."""
    corners = [(-60.0, -9.0), (60.0, -9.0)], [(-60.0, 9.0), (60.0, 9.0)]
    walls = tuple(ScriptedObstacle(list(ends), 4.0, kind="wall", reflectivity=0.3) for ends in corners)
    cars = [ScriptedActor(x_m=x, y_m=y, reflectivity=paint) for x, y, paint in ((22.0, 3.0, 0.4), (33.0, -3.0, 0.04))]
    where: Scene = scene(*cars, street=walls)
    config = noise(
        "dropout",
        "mirror",
        "layer_overlap",
        dropout=Dropout(random_rate=0.03),
        dirt=Dirt(enabled=True),
        sun=Sun(enabled=True, azimuth_deg=SUN_DEG),
        outage=_rear_left_out(),
    )
    lidar = Lidar(SRX, config, SensorConfig(), 1, where.obstacles)
    scan, truth = lidar.scan(where.frame)
    x, y, _ = scan.points_ego.T
    axes.scatter(x, y, s=2, color="tab:green", label=f"points ({len(scan)})")
    all_hits = cast(where, SRX, threshold=np.full(len(lidar.beams), 1e-9))
    first = np.diff(all_hits.echoes.beam, prepend=-1) > 0
    end = np.full((len(lidar.beams), 3), np.nan)
    end[all_hits.echoes.beam[first]] = all_hits.points_ego[first]
    start = np.searchsorted(lidar.beams.unit, np.arange(len(SRX.mounts)))
    beam = start[truth.lost_unit] + truth.lost_beam
    for loss, color in LOSS_COLORS.items():
        own = beam[truth.lost_cause == loss]
        if len(own):
            axes.scatter(end[own, 0], end[own, 1], s=7, color=color, label=f"{loss.name.lower()} ({len(own)})")
    axes.set(xlim=(-62, 62), ylim=(-11, 15))
    axes.legend(fontsize=8, loc="upper center", ncols=6, markerscale=2.5)
    label(
        axes,
        "Where the beams of one scan ended, and why those without an echo were lost (the arcs are the road)",
        "x forward [m]",
        "y left [m]",
    )


def _rear_left_out() -> Outage:
    """Return an outage of the rear left unit in the first second."""
    return Outage(enabled=True, mean_uptime_s=1e9, fixed=(FixedOutage("rear left", 0.0, 1.0),))
