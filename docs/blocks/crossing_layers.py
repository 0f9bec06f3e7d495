"""Layers of the animation: town, points, ground truth, fits and tracks, in the world frame."""

from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from blocks.steps import Step
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from luxloop.arrays import Floats
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading.plane_geometry import CORNER_SIGNS, corner, into_frame, out_of_frame, turned
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Obstacles
from luxloop.tracker.records import Status

NIGHT, ROAD, HOUSE, FAINT, TEXT = "#0f141c", "#1d2531", "#2f3a4b", "#8796b0", "#eef2f7"
POINT, TRUTH, HIDDEN, FIT, EGO = "#4cc9f0", "#ffffff", "#ef5d60", "#ffd166", "#ffffff"
TRACKS = ("#80ed99", "#b794ff", "#ff9f6e", "#f78fc3")
"""Tracks take these in turn, by id."""
DASHES = (0, (2, 1.5))
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


def fit_poses(step: Step) -> Floats:
    """Return the (N, 3) poses of the fitted boxes."""
    boxes = step.trace.boxes
    return out_of_frame(np.column_stack([boxes.center_ego, boxes.heading]), step.frame.ego.pose_world)


def track_poses(step: Step) -> Floats:
    """Return the (N, 3) poses of the tracks."""
    in_odom = np.column_stack([step.tracks.center_odom, step.tracks.mean[:, 6]])
    return out_of_frame(into_frame(in_odom, step.scan.ego_pose_odom), step.frame.ego.pose_world)


def draw_town(axes: Axes, obstacles: Obstacles, scenario: str) -> None:
    """Draw the lanes of the net and the buildings."""
    net = ElementTree.parse(find(scenario).parent / scenario / "crossing.net.xml")
    for junction in net.iter("junction"):
        if shape := junction.get("shape"):
            axes.add_patch(Polygon(coordinates(shape), color=ROAD, linewidth=0))
    for lane in net.iterfind("edge[lane]/lane"):
        if not lane.attrib["id"].startswith(":") and lane.get("allow") != "pedestrian":
            draw_lane(axes, coordinates(lane.attrib["shape"]), float(lane.attrib["width"]))
    for house in np.split(obstacles.vertices_world, obstacles.offset[1:-1]):
        axes.add_patch(Polygon(house, color=HOUSE, linewidth=0))


def coordinates(shape: str) -> Floats:
    """(N, 2) corners of a shape as SUMO writes it [m]."""
    return np.array([pair.split(",")[:2] for pair in shape.split()], dtype=float)


def draw_lane(axes: Axes, line: Floats, width: float) -> None:
    """Draw a straight lane with its edges."""
    begin, end = line[[0, -1]]
    along = (end - begin) / np.linalg.norm(end - begin)
    side = 0.5 * width * np.array([-along[1], along[0]])
    axes.add_patch(Polygon([begin + side, end + side, end - side, begin - side], color=ROAD, linewidth=0))
    for edge in (side, -side):
        axes.plot(*np.transpose([begin + edge, end + edge]), color=HOUSE, linewidth=0.6, zorder=1)


def draw_step(axes: Axes, step: Step, look: Look) -> None:
    """Draw points, truth, fits and tracks of one frame."""
    actors, ego = step.frame.actors, step.frame.ego
    points = turned(step.scan.points_ego[:, :2].astype(np.float64), ego.pose_world[2]) + ego.pose_world[:2]
    on_actor = step.truth.actor_id != NO_ACTOR
    for mine, color, order in ((~on_actor, FAINT, 2), (on_actor, POINT, 8)):
        x, y = points[mine].T
        axes.scatter(x, y, s=look.point_size, c=color, linewidths=0, zorder=order)
    hidden = step.truth.visible_fraction < VISIBLE_MIN
    poses, sizes = actors.pose_world, actors.size[:, :2]
    draw_boxes(axes, poses[~hidden], sizes[~hidden], edgecolor=TRUTH, linewidth=look.line, zorder=6)
    dashed = {"edgecolor": HIDDEN, "linewidth": 1.2 * look.line, "linestyle": DASHES}
    draw_boxes(axes, poses[hidden], sizes[hidden], zorder=3, **dashed)
    fitted = {"edgecolor": FIT, "linewidth": 1.6 * look.line}
    draw_boxes(axes, fit_poses(step), step.trace.boxes.size, zorder=7, **fitted)
    draw_tracks(axes, step, look)
    draw_boxes(axes, ego.pose_world[None], ego.size[None, :2], facecolor=EGO, edgecolor=EGO, zorder=6)
    if look.text_size:
        write(axes, ego.pose_world[:2], "ego", look, color=NIGHT)


def draw_boxes(axes: Axes, poses: Floats, sizes: Floats, **style: Any) -> None:
    """Draw boxes with poses (N, 3) and sizes (N, 2), empty unless the style fills them."""
    boxes = np.column_stack([poses, sizes])
    axes.add_collection(PolyCollection(list(corner(boxes[:, None], CORNER_SIGNS)), **{"facecolor": "none", **style}))


def draw_tracks(axes: Axes, step: Step, look: Look) -> None:
    """Draw the confirmed tracks, each with an arrow of one second of its motion, its id and its speed."""
    tracks, poses = step.tracks, track_poses(step)
    velocities = turned(tracks.mean[:, 2:4], step.frame.ego.pose_world[2] - step.scan.ego_pose_odom[2])
    for row in np.flatnonzero(tracks.status == Status.CONFIRMED):
        color, velocity = TRACKS[tracks.id[row] % len(TRACKS)], velocities[row]
        style = {"facecolor": f"{color}38", "edgecolor": color, "linewidth": 2.4 * look.line}
        draw_boxes(axes, poses[row, None], tracks.size[row, None], zorder=5, **style)
        if look.text_size:
            write(axes, poses[row, :2], str(tracks.id[row]), look, color=TEXT, **BOLD)
        speed = float(np.hypot(*velocity))
        if speed > MOVES_MPS:
            front = poses[row, :2] + 0.5 * tracks.size[row, 0] * velocity / speed
            arrow = [front, front + velocity]
            axes.add_collection(LineCollection([arrow], colors=color, linewidths=1.4, zorder=5))
            if look.text_size:
                write(axes, front + velocity, f"{speed:.0f} m/s", look, color=color, **BOLD)


BOLD = {"fontweight": "bold", "path_effects": [withStroke(linewidth=2.0, foreground=NIGHT)]}
"""Style of the texts of tracks."""


def write(axes: Axes, at: Floats, text: str, look: Look, **style: Any) -> None:
    """Write a text on the map."""
    x, y = at
    axes.text(x, y, text, fontsize=look.text_size, ha="center", va="center", zorder=9, clip_on=True, **style)
