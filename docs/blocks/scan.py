"""Draw one scan of the scenario `ring` in plan, and one of its cars with the fitted rectangles."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Cause, ScanTruth
from luxloop.sim.scripted.scripted_source import ScriptedSource
from luxloop.sim.world import WorldFrame
from luxloop.tracker.records import METHODS, StepTrace
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker

PICTURE = Path(__file__).parents[1] / "pictures" / "scan.png"
FRAME, CAR = 27, 2
"""Frame in which two sides, the mirrors and the windscreen of the car with this id are visible."""
CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])
METHOD_COLORS = ("tab:red", "tab:green", "tab:blue", "tab:purple", "tab:cyan")
COLORS = {Cause.CLEAN: "black", Cause.MIRROR: "magenta", Cause.LAYER_OVERLAP: "darkorange"}


def outline(x: float, y: float, yaw: float, length: float, width: float) -> np.ndarray:
    """Return (5, 2) corners of a closed box outline [m]."""
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    return (x, y) + 0.5 * CORNERS * (length, width) @ turn


def frame_of_the_ring() -> tuple[WorldFrame, Scan, ScanTruth, StepTrace]:
    """Simulate the scenario up to the frame; the ego is at the origin, so that ego and world frame coincide."""
    scenario = Scenario.load(find("ring"))
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = ScriptedSource(scenario.traffic, scenario.folder, range_m=100.0)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
    tracker = Tracker(scenario.tracker)
    for _ in range(FRAME):
        frame = source.step()
        scan, truth = lidar.scan(frame)
        _, trace = tracker.step(scan)
    return frame, scan, truth, trace


def draw_all(axes: Axes, frame: WorldFrame, scan: Scan) -> None:
    """Draw every point by its unit, and the true boxes."""
    x, y, _ = scan.points_ego.T
    axes.scatter(x, y, c=scan.unit, s=2, cmap="tab10")
    for pose, size in zip(frame.actors.pose_world, frame.actors.size, strict=True):
        axes.plot(*outline(*pose, *size[:2]).T, color="0.6", linewidth=1)
    axes.add_patch(plt.Polygon(outline(*frame.ego.pose_world, *frame.ego.size[:2]), color="black"))
    axes.set(xlim=(-37, 37), ylim=(-37, 37), title="A scan, one colour a unit", xlabel="x [m]", ylabel="y [m]")


def draw_car(axes: Axes, frame: WorldFrame, scan: Scan, truth: ScanTruth, trace: StepTrace) -> None:
    """Draw one car's points by cause, its true box and all rectangles fitted to it, the selected one thick."""
    own = truth.actor_id == CAR
    for cause, color in COLORS.items():
        x, y, _ = scan.points_ego[own & (truth.cause == cause)].T
        axes.scatter(x, y, s=7, color=color, label=f"points: {cause.name.lower().replace('_', ' ')}", zorder=3)
    row = int(np.flatnonzero(frame.actors.id == CAR)[0])
    axes.plot(*outline(*frame.actors.pose_world[row], *frame.actors.size[row, :2]).T, "0.6", label="truth")
    label = trace.segments.label[own]
    segment = np.bincount(label[label >= 0]).argmax()
    for m, method in enumerate(METHODS):
        found, best = trace.candidates, bool(trace.candidates.best[segment] == m)
        box = (*found.center_ego[segment, m], found.heading[segment, m], *found.size[segment, m])
        axes.plot(
            *outline(*box).T,
            METHOD_COLORS[m],
            linewidth=2.5 if best else 1.0,
            label=f"{method}{' (selected)' if best else ''}",
        )
    axes.set(title=f"One of its cars at {np.hypot(*frame.actors.pose_world[row, :2]):.0f} m", xlabel="x [m]")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))


def draw(_name: str) -> None:
    """Write the picture."""
    frame, scan, truth, trace = frame_of_the_ring()
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.2))
    draw_all(left, frame, scan)
    draw_car(right, frame, scan, truth, trace)
    for axes in (left, right):
        axes.set_aspect("equal")
    figure.tight_layout()
    figure.savefig(PICTURE, dpi=110)
