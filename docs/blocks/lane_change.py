"""Picture of a lane change on the motorway that SUMO makes in one step, before and after the truth layer."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import libsumo
import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from sensor_pictures.stage import label

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.sim.kinematics import Kinematics, RawFrame
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.roster import Member, Roster
from luxloop.sim.sumo.ego_choice import await_ego
from luxloop.sim.sumo.input_checks import sumo_command
from luxloop.sim.sumo.reader import SumoReader

Floats = npt.NDArray[np.float64]

PICTURE = Path(__file__).parents[1] / "pictures" / "motion_lane_change.png"
SCENARIO, DT, RANGE_M, SEED = "sumo-cut-in", 0.08, 200.0, 1
JUMPER = "entering.32"
"""Changes from the ramp to the right lane."""
BEFORE_S, AFTER_S = 2.4, 2.6
EVERY = 5
"""Frames between two boxes in the picture."""
_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])


@dataclass(frozen=True)
class Course:
    """Motion of one car over N consecutive frames."""

    time: Floats
    """(N,) [s]"""
    pose: Floats
    """(N, 3) box centre [m], yaw [rad]."""
    size: Floats
    """(2,) length, width [m]."""

    def part(self, begin: float, end: float) -> "Course":
        """Return the part in a time interval [s]."""
        rows = (self.time > begin - 0.5 * DT) & (self.time < end + 0.5 * DT)
        return replace(self, time=self.time[rows], pose=self.pose[rows])

    def acceleration(self) -> Floats:
        """Return the magnitude of the second difference quotient (N - 2,) [m/s^2]."""
        return np.asarray(np.hypot(*np.diff(self.pose[:, :2], 2, axis=0).T) / DT**2)


def draw(_name: str) -> None:
    """Write the picture."""
    raw_frames, lanes = simulated()
    raw = course((index, frame.members, frame.pose_world) for index, frame in enumerate(raw_frames))
    true = course((index, members, motion.pose_world) for index, (members, motion) in enumerate(delivered(raw_frames)))
    jump = int(raw.acceleration().argmax())
    begin, end = raw.time[jump + 1] - BEFORE_S, raw.time[jump + 1] + AFTER_S
    shown = ((raw.part(begin, end), "tab:red", "SUMO"), (true.part(begin, end), "tab:blue", "Delivered"))
    middle = np.array([*raw.pose[jump + 1, :2], shown[1][0].pose[0, 2]])
    figure = plt.figure(figsize=(11.0, 6.6), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(1, 1, 2.3))
    for row, (one, color, name) in enumerate(shown):
        _draw_boxes(figure.add_subplot(grid[row, :]), lanes, one, color, name)
    across, accelerations = figure.add_subplot(grid[2, 0]), figure.add_subplot(grid[2, 1])
    for one, color, name in shown:
        _draw_curves(across, accelerations, one, middle, color, name)
    for axes in (across, accelerations):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    label(across, "Box centre across the road", "time [s]", "to the left [m]")
    label(accelerations, "Acceleration, from differences of positions", "time [s]", "[m/s²], logarithmic")
    figure.savefig(PICTURE, dpi=95)
    plt.close(figure)


def simulated() -> tuple[list[RawFrame], list[tuple[Floats, float]]]:
    """Return SUMO's frames with its default options, and centre line and width [m] of each lane."""
    scenario = Scenario.load(find(SCENARIO))
    traffic = replace(scenario.traffic, options={})
    files = {"net-file": [traffic.net], "route-files": traffic.routes, "additional-files": traffic.additional}
    libsumo.start(sumo_command(scenario.folder, files, DT, SEED, traffic.options))
    ego, raw = await_ego(libsumo, traffic.ego, until=traffic.max_wait_s), []
    reader = SumoReader(libsumo, ego, Roster(SEED, redraw_default_sizes=True), [], RANGE_M, DT)
    while len(raw) < round(scenario.duration_s / DT) and (frame := reader.read()):
        raw.append(frame)
        libsumo.simulationStep()
    names = [name for name in libsumo.lane.getIDList() if not name.startswith(":")]
    lanes = [(np.array(libsumo.lane.getShape(name)), libsumo.lane.getWidth(name)) for name in names]
    libsumo.close()
    return raw, lanes


def delivered(raw: list[RawFrame]) -> list[tuple[list[Member], Kinematics]]:
    """Return the output of the truth layer."""
    layer, settled = PhysicalTruth(DT, PhysicalConfig(), rolling=True), []
    for frame in raw:
        layer.push(frame)
        if done := layer.pop():
            settled.append(done)
    layer.end()
    while done := layer.pop():
        settled.append(done)
    return settled


def course(frames: Iterator[tuple[int, list[Member], Floats]]) -> Course:
    """Return the course of the car that jumps."""
    found = [
        (DT * index, pose, member.size[:2])
        for index, members, poses in frames
        for member, pose in zip(members, poses, strict=True)
        if member.name == JUMPER
    ]
    time, pose, size = zip(*found, strict=True)
    return Course(np.array(time), np.array(pose), np.array(size[0]))


def _draw_boxes(axes: Axes, lanes: list[tuple[Floats, float]], course: Course, color: str, name: str) -> None:
    """Draw the lanes, the boxes from above and a point for each frame."""
    for line, width in lanes:
        step = np.gradient(line, axis=0)
        left = np.column_stack([-step[:, 1], step[:, 0]]) / np.hypot(*step.T)[:, None]
        for side in (-0.5, 0.5):
            axes.plot(*(line + side * width * left).T, color="0.8", linewidth=0.7, zorder=0)
    for x, y, yaw in course.pose[::EVERY]:
        turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
        box = (x, y) + 0.5 * _CORNERS * course.size @ turn
        axes.fill(*box.T, facecolor=color, alpha=0.25)
        axes.plot(*box.T, color=color, linewidth=1.0)
    axes.plot(*course.pose[:, :2].T, ".", color=color, markersize=2)
    x = course.pose[:, 0]
    axes.set(xlim=(x.min() - 4, x.max() + 4), ylim=(-9.5, 0.5), aspect="equal")
    title = f"{name}: in the next lane from one step to the next" if name == "SUMO" else name
    label(axes, f"{title} (a point every {DT:.2f} s, a box every {EVERY * DT:.1f} s)", "x [m]", "y [m]")


def _draw_curves(across: Axes, accelerations: Axes, course: Course, middle: Floats, color: str, name: str) -> None:
    """Draw the lateral position, from the middle between the lanes, and the acceleration."""
    style = {"color": color, "markersize": 3, "linewidth": 1}
    time = course.time - course.time[0]
    left = (course.pose[:, :2] - middle[:2]) @ [-np.sin(middle[2]), np.cos(middle[2])]
    across.plot(time, left, ".-", label=name, **style)
    size = course.acceleration()
    most = f"at most {size.max():.{0 if size.max() > 10 else 1}f} m/s²"
    accelerations.semilogy(time[1:-1], size, ".-", label=f"{name}: {most}", **style)
