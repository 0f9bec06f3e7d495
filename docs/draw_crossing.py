"""Draw the animation in the README: the scenario `sumo-crossing` from above, with LIDAR points, fits and tracks.

python docs/draw_crossing.py    # half a minute
"""

import io
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from PIL import Image

from scenarios.files.scenario import Scenario
from scenarios.files.shipped import find
from sensor_model.lidar import Lidar
from sensor_model.rig.rig import load_rig
from sensor_model.truth import NO_ACTOR, ScanTruth
from sim.factory import make_source
from sim.world import Obstacles, WorldFrame
from tracker.geometry import rotate
from tracker.records import Boxes, Status, StepTrace, Tracks
from tracker.scan import Scan
from tracker.tracker import Tracker

PICTURE = Path(__file__).parent / "pictures" / "crossing.gif"
BEGIN_S, END_S = 22.7, 30.3
"""The light turns green, the queue starts, and the ego crosses [s]."""
EVERY = 2
"""Frames from one picture to the next."""
PICTURE_S = 0.16
"""Time that a picture is shown: real time [s]."""
COLORS = 128
MAP_M = (-26.0, 38.0, -39.0, 25.0)
"""West, east, south and north edge of the map, world frame [m]."""
CLOSE_UP_M = 3.4
"""Half the width of the close-up [m]."""
CLOSE_UP_OF = "s_n.17"
"""The actor in the close-up, by its name in SUMO."""
MOVES_MPS = 0.5
"""Slower tracks get no speed."""
VISIBLE_MIN = 0.2
"""Actors of which less than this fraction is visible are drawn as hidden."""

NIGHT, ROAD, HOUSE, FAINT, TEXT = "#0f141c", "#1d2531", "#2f3a4b", "#8796b0", "#eef2f7"
POINT, TRUTH, HIDDEN, FIT, EGO = "#4cc9f0", "#ffffff", "#ef5d60", "#ffd166", "#ffffff"
TRACKS = ("#80ed99", "#b794ff", "#ff9f6e", "#f78fc3")
"""Tracks take these in turn, by id."""
CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


class Step(NamedTuple):
    """All records of one frame."""

    frame: WorldFrame
    scan: Scan
    truth: ScanTruth
    tracks: Tracks
    trace: StepTrace


def play() -> tuple[Obstacles, Iterator[Step]]:
    """Return the obstacles, and the frames from BEGIN_S to END_S."""
    scenario = Scenario.load(find("sumo-crossing"))
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = make_source(scenario.traffic, scenario.folder, max(mount.model.range_max_m for mount in rig.mounts))
    obstacles = source.reset(scenario.seed)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, obstacles)
    tracker = Tracker(scenario.tracker)

    def steps() -> Iterator[Step]:
        with closing(source):
            for _ in range(round(END_S / source.dt)):
                frame = source.step()
                scan, truth = lidar.scan(frame)
                tracks, trace = tracker.step(scan)
                if frame.time >= BEGIN_S:
                    yield Step(frame, scan, truth, tracks, trace)

    return obstacles, steps()


def outlines(pose: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(N, 4, 2) corners of boxes with poses (N, 3) and sizes (N, 2 or 3) [m, rad]."""
    yaw = np.repeat(pose[:, 2], 4)
    corners = 0.5 * CORNERS * size[:, None, :2]
    return pose[:, None, :2] + rotate(corners.reshape(-1, 2), yaw).reshape(-1, 4, 2)


def to_world(step: Step, points: np.ndarray, pose_of_ego: np.ndarray) -> np.ndarray:
    """(N, 2) points of a frame in which the ego has `pose_of_ego` (3,), in the world frame [m]."""
    turn = step.frame.ego.pose_world[2] - pose_of_ego[2]
    offset = points[:, :2] - pose_of_ego[:2]
    return step.frame.ego.pose_world[:2] + rotate(offset, np.full(len(points), turn))


def polygons(axes: Axes, corners: np.ndarray, **style: object) -> None:
    """Draw closed polygons (N, 4, 2)."""
    axes.add_collection(PolyCollection(list(corners), **style))


class Look(NamedTuple):
    """Style in which the map and the close-up differ: areas of points, widths of lines, sizes of text."""

    point_size: float
    line: float
    text_size: float


MAP, CLOSE_UP = Look(3.0, 0.8, 8.0), Look(7.0, 1.5, 0.0)


def draw_town(axes: Axes, obstacles: Obstacles) -> None:
    """Draw the lanes of the net and the buildings."""
    net = ElementTree.parse(find("sumo-crossing").parent / "sumo-crossing" / "crossing.net.xml")
    for junction in net.iter("junction"):
        if shape := junction.get("shape"):
            axes.add_patch(Polygon(coordinates(shape), color=ROAD, linewidth=0))
    for edge in net.iter("edge"):
        for lane in edge.iter("lane"):
            if edge.get("function") is None and lane.get("allow") != "pedestrian":
                draw_lane(axes, coordinates(lane.attrib["shape"]), float(lane.attrib["width"]))
    for begin, end in zip(obstacles.offset[:-1], obstacles.offset[1:], strict=True):
        axes.add_patch(Polygon(obstacles.vertices_world[begin:end], color=HOUSE, linewidth=0))


def coordinates(shape: str) -> np.ndarray:
    """(N, 2) corners of a shape as SUMO writes it [m]."""
    return np.array([pair.split(",")[:2] for pair in shape.split()], dtype=float)


def draw_lane(axes: Axes, line: np.ndarray, width: float) -> None:
    """Draw a straight lane with its edges."""
    along = (line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0])
    side = 0.5 * width * np.array([-along[1], along[0]])
    axes.add_patch(Polygon([line[0] + side, line[-1] + side, line[-1] - side, line[0] - side], color=ROAD, linewidth=0))
    for edge in (side, -side):
        axes.plot(*np.transpose([line[0] + edge, line[-1] + edge]), color=HOUSE, linewidth=0.6, zorder=1)


def draw_step(axes: Axes, step: Step, look: Look) -> None:
    """Draw points, truth, fits and tracks of one frame."""
    frame, actors = step.frame, step.frame.actors
    points = to_world(step, step.scan.points_ego, np.zeros(3))
    on_actor = step.truth.actor_id != NO_ACTOR
    for mine, color, order in ((~on_actor, FAINT, 2), (on_actor, POINT, 8)):
        axes.scatter(*points[mine].T, s=look.point_size, c=color, linewidths=0, zorder=order)
    hidden = step.truth.visible_fraction < VISIBLE_MIN
    boxes = outlines(actors.pose_world, actors.size)
    polygons(axes, boxes[~hidden], facecolor="none", edgecolor=TRUTH, linewidth=look.line, zorder=6)
    dashed = {"edgecolor": HIDDEN, "linewidth": 1.2 * look.line, "linestyle": (0, (2, 1.5))}
    polygons(axes, boxes[hidden], facecolor="none", zorder=3, **dashed)
    draw_fits(axes, step, step.trace.boxes, look)
    draw_tracks(axes, step, look)
    ego = outlines(frame.ego.pose_world[None], frame.ego.size[None])
    polygons(axes, ego, facecolor=EGO, edgecolor=EGO, zorder=6)
    if look.text_size:
        x, y, _ = frame.ego.pose_world
        axes.text(x, y, "ego", color=NIGHT, fontsize=look.text_size, ha="center", va="center", zorder=9, clip_on=True)


def draw_fits(axes: Axes, step: Step, boxes: Boxes, look: Look) -> None:
    """Draw the selected rectangle of each segment of vehicle size."""
    ego = step.frame.ego.pose_world
    pose = np.column_stack([to_world(step, boxes.center_ego, np.zeros(3)), boxes.heading + ego[2]])
    polygons(axes, outlines(pose, boxes.size), facecolor="none", edgecolor=FIT, linewidth=1.6 * look.line, zorder=7)


def draw_tracks(axes: Axes, step: Step, look: Look) -> None:
    """Draw the confirmed tracks, each with an arrow of one second of its motion, its id and its speed."""
    tracks, ego, odom = step.tracks, step.frame.ego.pose_world, step.scan.ego_pose_odom
    shown = tracks.status == Status.CONFIRMED
    center = to_world(step, tracks.center_odom, odom)
    turn = ego[2] - odom[2]
    velocity = rotate(tracks.mean[:, 2:4], np.full(len(tracks), turn))
    box = outlines(np.column_stack([center, tracks.mean[:, 6] + turn]), tracks.size)
    for row in np.flatnonzero(shown):
        color = TRACKS[tracks.id[row] % len(TRACKS)]
        speed = float(np.hypot(*velocity[row]))
        axes.add_patch(Polygon(box[row], facecolor=f"{color}38", edgecolor=color, linewidth=2.4 * look.line, zorder=5))
        if look.text_size:
            write(axes, center[row], str(tracks.id[row]), TEXT, look)
        if speed > MOVES_MPS:
            front = center[row] + 0.5 * tracks.size[row, 0] * velocity[row] / speed
            tip = front + velocity[row]
            axes.add_collection(LineCollection([[front, tip]], colors=color, linewidths=1.4, zorder=5))
            if look.text_size:
                write(axes, tip, f"{speed:.0f} m/s", color, look)


def write(axes: Axes, at: np.ndarray, text: str, color: str, look: Look) -> None:
    """Write a track's id or speed on the map."""
    axes.text(
        *at,
        text,
        color=color,
        fontsize=look.text_size,
        fontweight="bold",
        ha="center",
        va="center",
        zorder=9,
        clip_on=True,
        path_effects=[withStroke(linewidth=2.0, foreground=NIGHT)],
    )


def legend(figure: Figure) -> None:
    """Explain the colours."""

    def line(color: str, name: str, **style: object) -> Line2D:
        return Line2D([], [], color=color, label=name, **style)

    entries = [
        line(EGO, "ego with six LIDARs", marker="s", linestyle="none", markersize=9),
        line(POINT, "LIDAR points on road users", marker="o", linestyle="none", markersize=4),
        line(FAINT, "LIDAR points on buildings", marker="o", linestyle="none", markersize=4),
        line(TRUTH, "true vehicle", linewidth=1.2),
        line(HIDDEN, "true vehicle, hidden", linewidth=1.2, linestyle=(0, (2, 1.5))),
        line(FIT, "rectangle fitted to one scan", linewidth=1.5),
        line(TRACKS[0], "track: id, speed, motion in 1 s", linewidth=2.6),
    ]
    figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=(0.712, 0.845),
        frameon=False,
        labelcolor=TEXT,
        fontsize=9.5,
        handlelength=1.6,
        labelspacing=0.62,
        borderpad=0,
    )


def picture(step: Step, obstacles: Obstacles) -> Image.Image:
    """Draw one frame: the map at the left, the legend and the close-up at the right."""
    figure = plt.figure(figsize=(9.6, 6.72), dpi=100, facecolor=NIGHT)
    town = figure.add_axes((0.0, 0.0, 0.70, 1.0))
    near = figure.add_axes((0.715, 0.025, 0.27, 0.27 * 9.6 / 6.72))
    for axes in (town, near):
        axes.set(facecolor=NIGHT, xticks=[], yticks=[], aspect="equal")
        for spine in axes.spines.values():
            spine.set(color=FAINT, visible=axes is near)
    draw_town(town, obstacles)
    draw_step(town, step, MAP)
    draw_step(near, step, CLOSE_UP)
    town.set(xlim=MAP_M[:2], ylim=MAP_M[2:])
    row = int(np.flatnonzero(step.frame.actors.name == CLOSE_UP_OF)[0])
    x, y, _ = step.frame.actors.pose_world[row]
    near.set(xlim=(x - CLOSE_UP_M, x + CLOSE_UP_M), ylim=(y - CLOSE_UP_M, y + CLOSE_UP_M))
    corner = np.array([x - CLOSE_UP_M, y - CLOSE_UP_M])
    side = 2 * CLOSE_UP_M
    town.add_patch(plt.Rectangle(corner, side, side, fill=False, edgecolor=FAINT, linewidth=0.8, zorder=8))
    figure.text(0.715, 0.945, "luxloop", color=TEXT, fontsize=17, fontweight="bold")
    figure.text(0.715, 0.905, "sumo-crossing from above", color=TEXT, fontsize=10.5)
    figure.text(0.715, 0.875, f"{step.frame.time:4.1f} s", color=FAINT, fontsize=10.5)
    figure.text(0.715, 0.495, "close-up", color=TEXT, fontsize=10.5)
    for y, (name, error_deg) in zip((0.46, 0.43), heading_errors(step, row).items(), strict=True):
        figure.text(0.715, y, f"heading error of the {name}", color=FAINT, fontsize=10)
        figure.text(0.985, y, f"{error_deg:.1f}\N{DEGREE SIGN}", color=FAINT, fontsize=10, ha="right")
    draw_scale(town)
    legend(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, facecolor=NIGHT)
    plt.close(figure)
    return Image.open(buffer).convert("RGB")


def heading_errors(step: Step, row: int) -> dict[str, float]:
    """Return the absolute heading errors of the nearest fit, modulo 90, and the nearest track, modulo 360 [deg]."""
    pose, ego, odom = step.frame.actors.pose_world[row], step.frame.ego.pose_world, step.scan.ego_pose_odom
    fits, tracks = step.trace.boxes, step.tracks
    fit = nearest(to_world(step, fits.center_ego, np.zeros(3)), pose)
    track = nearest(to_world(step, tracks.center_odom, odom), pose)
    of_fit = np.rad2deg(fits.heading[fit] + ego[2] - pose[2])
    of_track = np.rad2deg(tracks.mean[track, 6] + ego[2] - odom[2] - pose[2])
    return {"fit": abs((of_fit + 45.0) % 90.0 - 45.0), "track": abs((of_track + 180.0) % 360.0 - 180.0)}


def nearest(points: np.ndarray, pose: np.ndarray) -> int:
    """Return the row of the point nearest to a pose."""
    return int(np.linalg.norm(points - pose[:2], axis=1).argmin())


def draw_scale(axes: Axes) -> None:
    """Draw a bar of 10 m."""
    x, y = MAP_M[0] + 2.0, MAP_M[2] + 2.0
    axes.plot([x, x + 10.0], [y, y], color=TEXT, linewidth=2, zorder=9)
    axes.text(x + 5.0, y + 0.8, "10 m", color=TEXT, fontsize=8, ha="center", zorder=9)


def main() -> None:
    """Write the animation."""
    obstacles, steps = play()
    pictures = [picture(step, obstacles) for n, step in enumerate(steps) if n % EVERY == 0]
    save(pictures)


def save(pictures: list[Image.Image]) -> None:
    """Write pictures as an animation, with one palette for all so that still parts cost nothing."""
    sample = Image.new("RGB", (pictures[0].width, 3 * pictures[0].height))
    for n, shown in enumerate((0, len(pictures) // 2, -1)):
        sample.paste(pictures[shown], (0, n * pictures[0].height))
    palette = sample.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=3)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in pictures]
    frames[0].save(
        PICTURE, save_all=True, append_images=frames[1:], duration=round(1000 * PICTURE_S), loop=0, optimize=True
    )


if __name__ == "__main__":
    main()
