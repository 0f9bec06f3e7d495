"""Layers of the picture: town, points, ground truth, fits and tracks."""

from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from crossing_picture.scene import SCENARIO, Floats, Step, outlines, to_world
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from luxloop.scenarios.files.shipped import find
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Obstacles
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import Boxes, Status

NIGHT, ROAD, HOUSE, FAINT, TEXT = "#0f141c", "#1d2531", "#2f3a4b", "#8796b0", "#eef2f7"
POINT, TRUTH, HIDDEN, FIT, EGO = "#4cc9f0", "#ffffff", "#ef5d60", "#ffd166", "#ffffff"
TRACKS = ("#80ed99", "#b794ff", "#ff9f6e", "#f78fc3")
"""Tracks take these in turn, by id."""
MOVES_MPS = 0.5
"""Slower tracks get no speed."""
VISIBLE_MIN = 0.2
"""Actors of which less than this fraction is visible are drawn as hidden."""


class Look(NamedTuple):
    """Style in which the map and the close-up differ: areas of points, widths of lines, sizes of text."""

    point_size: float
    line: float
    text_size: float


MAP, CLOSE_UP = Look(3.0, 0.8, 8.0), Look(7.0, 1.5, 0.0)


def draw_town(axes: Axes, obstacles: Obstacles) -> None:
    """Draw the lanes of the net and the buildings."""
    net = ElementTree.parse(find(SCENARIO).parent / SCENARIO / "crossing.net.xml")
    for junction in net.iter("junction"):
        if shape := junction.get("shape"):
            axes.add_patch(Polygon(coordinates(shape), color=ROAD, linewidth=0))
    for edge in net.iter("edge"):
        for lane in edge.iter("lane"):
            if edge.get("function") is None and lane.get("allow") != "pedestrian":
                draw_lane(axes, coordinates(lane.attrib["shape"]), float(lane.attrib["width"]))
    for begin, end in zip(obstacles.offset[:-1], obstacles.offset[1:], strict=True):
        axes.add_patch(Polygon(obstacles.vertices_world[begin:end], color=HOUSE, linewidth=0))


def coordinates(shape: str) -> Floats:
    """(N, 2) corners of a shape as SUMO writes it [m]."""
    return np.array([pair.split(",")[:2] for pair in shape.split()], dtype=float)


def draw_lane(axes: Axes, line: Floats, width: float) -> None:
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


def write(axes: Axes, at: Floats, text: str, color: str, look: Look) -> None:
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


def polygons(axes: Axes, corners: Floats, **style: object) -> None:
    """Draw closed polygons (N, 4, 2)."""
    axes.add_collection(PolyCollection(list(corners), **style))
