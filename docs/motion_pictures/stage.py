"""Common parts of the pictures: runs of SUMO, courses of its road users before and after the truth layer, drawing."""

from dataclasses import dataclass, replace
from pathlib import Path

import libsumo
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading.articulated import parts
from luxloop.sim.kinematics import Kinematics, RawFrame
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.roster import Member, Roster
from luxloop.sim.sumo.ego_choice import await_ego
from luxloop.sim.sumo.input_checks import sumo_command
from luxloop.sim.sumo.reader import SumoReader
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.world import JOINTS

Floats = npt.NDArray[np.float64]

FOLDER = Path(__file__).parents[1] / "pictures"
NETS = Path(__file__).parents[2] / "tests" / "nets"
DT, RANGE_M, SEED = 0.08, 200.0, 1
RAW, TRUE, ROAD = "tab:red", "tab:blue", "0.8"

INSTANT = {}
TIMED = {"lanechange.duration": "3"}
SUBLANES = {"lateral-resolution": "0.8"}
"""SUMO's options for its three modes of lane changes."""

_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])

Settled = list[tuple[list[Member], Kinematics]]


@dataclass(frozen=True)
class Traffic:
    """A run of SUMO: raw frames, and lanes without those across junctions."""

    raw: list[RawFrame]
    lanes: list[tuple[Floats, float]]
    """Centre line (K, 2) and width [m] of each lane."""

    def delivered(self, config: PhysicalConfig | None = None) -> Settled:
        """Return the output of the truth layer."""
        layer, settled = PhysicalTruth(DT, config or PhysicalConfig(), rolling=True), []
        for raw in self.raw:
            layer.push(raw)
            if frame := layer.pop():
                settled.append(frame)
        layer.end()
        while frame := layer.pop():
            settled.append(frame)
        return settled


def on_scenario(name: str, options: dict[str, str] | None = None) -> Traffic:
    """Run the traffic of a shipped scenario for its duration, optionally with other options."""
    scenario = Scenario.load(find(name))
    traffic = scenario.traffic if options is None else replace(scenario.traffic, options=options)
    return _run(traffic, scenario.folder, round(scenario.duration_s / DT))


def on_net(name: str, options: dict[str, str]) -> Traffic:
    """Run one minute on a test net."""
    routes = ["mixed.rou.xml", f"{name}/{name}.rou.xml"]
    traffic = SumoTraffic(net=f"{name}/{name}.net.xml", routes=routes, ego="vehicle:ego", options=options)
    return _run(traffic, NETS, 750)


def _run(traffic: SumoTraffic, folder: Path, frames: int) -> Traffic:
    """Run SUMO for a number of frames from the ego's entry, or until it is gone."""
    files = {"net-file": [traffic.net], "route-files": traffic.routes, "additional-files": traffic.additional}
    libsumo.start(sumo_command(folder, files, DT, SEED, traffic.options))
    ego, raw = await_ego(libsumo, traffic.ego, until=traffic.max_wait_s), []
    reader = SumoReader(libsumo, ego, Roster(SEED, redraw_default_sizes=True), [], RANGE_M, DT)
    while len(raw) < frames and (frame := reader.read()):
        raw.append(frame)
        libsumo.simulationStep()
    names = [name for name in libsumo.lane.getIDList() if not name.startswith(":")]
    lanes = [(np.array(libsumo.lane.getShape(name)), libsumo.lane.getWidth(name)) for name in names]
    libsumo.close()
    return Traffic(raw, lanes)


@dataclass(frozen=True)
class Course:
    """Motion of one road user over N consecutive frames."""

    member: Member
    time: Floats
    """(N,) [s]"""
    pose: Floats
    """(N, 3) box centre [m], yaw [rad]."""
    joint_angles: Floats
    """(N, JOINTS) [rad] see `luxloop.sim.world.Actors`."""

    def part(self, begin: float, end: float) -> "Course":
        """Return the part in a time interval [s]."""
        rows = (self.time > begin - 0.5 * DT) & (self.time < end + 0.5 * DT)
        return replace(self, time=self.time[rows], pose=self.pose[rows], joint_angles=self.joint_angles[rows])

    def differences(self, order: int) -> Floats:
        """Return difference quotients (N - order, 2) of the position: velocities, accelerations (2) or jerks (3)."""
        return np.asarray(np.diff(self.pose[:, :2], order, axis=0) / DT**order)

    def fronts(self) -> Floats:
        """Return the middle of the front bumper (N, 2) [m]; for an articulated truck, the tractor's."""
        row, pose, size = self._boxes()
        leads = dict(zip(row.tolist(), range(len(row)), strict=True))  # fronts come last
        pose, size = pose[list(leads.values())], size[list(leads.values())]
        return np.asarray(pose[:, :2] + 0.5 * size[:, :1] * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])]))

    def outlines(self, every: int) -> list[Floats]:
        """Return outlines (5, 2) [m] of its boxes, one of `every` frames; an articulated truck has two, a tram more."""
        row, pose, size = self._boxes()
        return [_outline(*pose[n], *size[n]) for n in np.flatnonzero(row % every == 0)]

    def _boxes(self) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
        kind = np.full(len(self.pose), self.member.kind, np.uint8)
        return parts(self.pose, np.tile(self.member.size[:2], (len(self.pose), 1)), self.joint_angles, kind)


def raw_courses(traffic: Traffic) -> list[Course]:
    """Return the courses in SUMO, by road user."""
    return _courses(
        [(frame.members, frame.pose_world, np.zeros((len(frame.members), JOINTS))) for frame in traffic.raw]
    )


def delivered_courses(settled: Settled) -> list[Course]:
    """Return the delivered courses, by road user."""
    return _courses([(members, motion.pose_world, motion.joint_angles) for members, motion in settled])


def named(courses: list[Course], name: str) -> Course:
    """Return the course of the road user with a name."""
    return next(course for course in courses if course.member.name == name)


def _courses(frames: list[tuple[list[Member], Floats, Floats]]) -> list[Course]:
    """Sort members, poses and articulations by member; members with an absence are left out."""
    seen: dict[int, list[tuple[Member, int, Floats, float]]] = {}
    for index, (members, poses, bends) in enumerate(frames):
        for member, pose, bend in zip(members, poses, bends, strict=True):
            seen.setdefault(member.id, []).append((member, index, pose, bend))
    columns = [tuple(zip(*rows, strict=True)) for rows in seen.values()]
    return [
        Course(member[0], DT * np.array(index), np.array(pose), np.array(bend))
        for member, index, pose, bend in columns
        if index[-1] - index[0] == len(index) - 1
    ]


def _outline(x: float, y: float, yaw: float, length: float, width: float) -> Floats:
    """Return the corners (5, 2) of a box, with the first repeated [m]."""
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    return np.asarray((x, y) + 0.5 * _CORNERS * (length, width) @ turn)


def draw_road(axes: Axes, traffic: Traffic) -> None:
    """Draw the borders of all lanes."""
    for line, width in traffic.lanes:
        step = np.gradient(line, axis=0)
        left = np.column_stack([-step[:, 1], step[:, 0]]) / np.hypot(*step.T)[:, None]
        for side in (-0.5, 0.5):
            axes.plot(*(line + side * width * left).T, color=ROAD, linewidth=0.7, zorder=0)


def save(figure: Figure, name: str) -> None:
    """Write a picture."""
    figure.savefig(FOLDER / f"motion_{name}.png", dpi=95)
    plt.close(figure)
