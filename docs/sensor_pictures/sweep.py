"""Motion during the sweep: firing times, a crossing car, a turning ego."""

import numpy as np
from matplotlib.axes import Axes
from sensor_pictures.stage import SRX, Scene, label, one_unit, outline, save, scene, sense, sheet

from luxloop.sensor_model.rig.beams import beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, load_unit
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.scripted.motions import Arc, Straight
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle

FROZEN = SensorConfig(sweep=False)
CROSSING_MPS = 30.0
EGO_MPS, EGO_DEG_PER_S = 15.0, 25.0


def draw() -> None:
    """Write the picture."""
    figure, panels = sheet(1, 3, 11.0, 4.3)
    _firing(panels[0, 0])
    _crossing(panels[0, 1])
    _turning(panels[0, 2])
    save(figure, "sweep")


def _firing(axes: Axes) -> None:
    """Draw the firing times of the beams."""
    for name, style in (("lux", "-"), ("lux_25hz", "--"), ("lux_50hz", ":")):
        model = load_unit(name, SHIPPED)
        table = beam_table(one_unit(model))
        order = np.argsort(table.azimuth)
        axes.plot(np.rad2deg(table.azimuth)[order], 1000.0 * table.time_offset[order], "k", linestyle=style,
                  label=f"{model.scan_rate_hz:g} Hz")  # fmt: skip
    axes.axhline(0.0, color="tab:red", linewidth=0.8)
    axes.text(58.0, 0.3, "frame's time", color="tab:red", fontsize=8)
    axes.set(xlim=(62, -62))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    label(axes, "Firing time of each beam of a LUX", "azimuth [deg], left positive", "time offset [ms]")


def _crossing(axes: Axes) -> None:
    """Draw a car that crosses ahead."""
    motion = [Straight("straight", speed_mps=CROSSING_MPS)]
    where = scene(ScriptedActor(x_m=16.0, y_m=0.0, yaw_deg=90.0, reflectivity=0.4, motion=motion))
    outline(axes, where.frame, color="black", along_y=True)
    axes.plot([], [], color="black", label="the car at the frame's time")
    _points(axes, where)
    axes.annotate("", (-1.6, 15.62), (0.4, 15.62), arrowprops={"arrowstyle": "<-"})
    axes.text(-0.6, 15.65, f"{CROSSING_MPS:.0f} m/s", ha="center", fontsize=8)
    axes.set(xlim=(3.0, -3.0), ylim=(15.0, 15.8))
    label(axes, "A car crosses from right to left", "y left [m]", "x forward [m] (stretched)")


def _turning(axes: Axes) -> None:
    """Draw a wall seen from a turning ego; points are in the ego frame at their firing times."""
    ego = ScriptedEgo(motion=[Arc("arc", speed_mps=EGO_MPS, radius_m=EGO_MPS / np.deg2rad(EGO_DEG_PER_S))])
    where = scene(ego=ego, street=(ScriptedObstacle([(28.0, -12.0), (28.0, 12.0)], kind="wall"),))
    axes.plot([-12.0, 12.0], [28.0, 28.0], color="black", label="the wall at the frame's time")
    _points(axes, where)
    axes.set(xlim=(13.0, -13.0), ylim=(27.5, 28.5))
    label(axes, f"A wall, while the ego drives {EGO_MPS:.0f} m/s\nand turns left at {EGO_DEG_PER_S:.0f} deg/s",
          "y left [m]", "x forward [m] (stretched)")  # fmt: skip


def _points(axes: Axes, where: Scene) -> None:
    """Draw the points of the two front units, with and without sweep."""
    x, y, _ = sense(where, sensor=FROZEN)[0].points_ego.T
    axes.scatter(y, x, s=14, color="0.75", label="points without sweep")
    scan, _ = sense(where)
    for unit, color in ((0, "tab:blue"), (1, "tab:orange")):
        x, y, _ = scan.points_ego[scan.unit == unit].T
        axes.scatter(y, x, s=5, color=color, label=f"swept, {SRX.mounts[unit].name} unit", zorder=3)
    axes.legend(fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False)
