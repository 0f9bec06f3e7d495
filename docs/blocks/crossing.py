"""Animation of the README: the scenario `sumo-crossing` from above, with LIDAR points, fits and tracks.

The map is at the left, legend and close-up at the right, all in the world frame.
"""

import io
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
from blocks.steps import Step, steps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.patheffects import withStroke
from PIL import Image

from luxloop.arrays import Floats
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.grading import plane_geometry as plane
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.sim.world import Obstacles
from luxloop.tracker.records import Status

PICTURE = Path(__file__).parents[1] / "pictures" / "crossing.gif"
SCENARIO = "sumo-crossing"
BEGIN_S, END_S = 22.7, 30.3
"""The light turns green, the queue starts, and the ego crosses [s]."""
EVERY, PICTURE_MS = 2, 160
"""Frames from one picture to the next, and the time that it is shown: real time [ms]."""
COLORS = 128
MAP_M = (-26.0, 38.0, -39.0, 25.0)
"""West, east, south and north edge of the map, world frame [m]."""
CLOSE_UP_M, CLOSE_UP_OF = 3.4, "s_n.17"
"""Half the width of the close-up [m], and the actor in it, by its name in SUMO."""
MOVES_MPS = 0.5
"""Slower tracks get no speed."""
VISIBLE_MIN = 0.2
"""Actors of which less than this fraction is visible are drawn as hidden."""
NIGHT, ROAD, HOUSE, FAINT, TEXT = "#0f141c", "#1d2531", "#2f3a4b", "#8796b0", "#eef2f7"
POINT, TRUTH, HIDDEN, FIT, EGO = "#4cc9f0", "#ffffff", "#ef5d60", "#ffd166", "#ffffff"
TRACKS = ("#80ed99", "#b794ff", "#ff9f6e", "#f78fc3")
"""Tracks take these in turn, by id."""
DASHES = (0, (2, 1.5))
BOLD = {"fontweight": "bold", "path_effects": [withStroke(linewidth=2.0, foreground=NIGHT)]}
"""Style of the texts of tracks."""
LEGEND = (
    (EGO, "ego with six LIDARs", {"marker": "s", "linestyle": "none", "markersize": 9}),
    (POINT, "LIDAR points on road users", {"marker": "o", "linestyle": "none", "markersize": 4}),
    (FAINT, "LIDAR points on buildings", {"marker": "o", "linestyle": "none", "markersize": 4}),
    (TRUTH, "true vehicle", {"linewidth": 1.2}),
    (HIDDEN, "true vehicle, hidden", {"linewidth": 1.2, "linestyle": DASHES}),
    (FIT, "rectangle fitted to one scan", {"linewidth": 1.5}),
    (TRACKS[0], "track: id, speed, motion in 1 s", {"linewidth": 2.6}),
)


class Look(NamedTuple):
    """Style in which the map and the close-up differ: areas of points, widths of lines, sizes of text."""

    point_size: float
    line: float
    text_size: float


MAP, CLOSE_UP = Look(3.0, 0.8, 8.0), Look(7.0, 1.5, 0.0)


def draw(_name: str) -> None:
    """Write the animation; half a minute."""
    shown = [step for step in steps(find(SCENARIO), END_S) if step.frame.time >= BEGIN_S]
    pictures = [picture(step) for step in shown[::EVERY]]
    sample = Image.fromarray(np.vstack([pictures[index] for index in (0, len(pictures) // 2, -1)]))
    palette = sample.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=3)  # one for all, for a small file
    first, *rest = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in pictures]
    first.save(PICTURE, save_all=True, append_images=rest, duration=PICTURE_MS, loop=0, optimize=True)


def picture(step: Step) -> Image.Image:
    """Draw one frame."""
    figure = plt.figure(figsize=(9.6, 6.72), dpi=100, facecolor=NIGHT)
    town = figure.add_axes((0.0, 0.0, 0.70, 1.0))
    near = figure.add_axes((0.715, 0.025, 0.27, 0.27 * 9.6 / 6.72))
    draw_town(town, step.obstacles)
    for axes, look in ((town, MAP), (near, CLOSE_UP)):
        draw_step(axes, step, look)
        axes.set(facecolor=NIGHT, xticks=[], yticks=[], aspect="equal")
        axes.spines[:].set(color=FAINT, visible=axes is near)
    (row,) = np.flatnonzero(step.frame.actors.name == CLOSE_UP_OF)
    pose = step.frame.actors.pose_world[row]
    (x, y), side = pose[:2] - CLOSE_UP_M, 2 * CLOSE_UP_M
    near.set(xlim=(x, x + side), ylim=(y, y + side))
    town.set(xlim=MAP_M[:2], ylim=MAP_M[2:])
    town.add_patch(Rectangle((x, y), side, side, fill=False, edgecolor=FAINT, linewidth=0.8, zorder=8))
    write_texts(figure, step, pose)
    buffer = io.BytesIO()
    figure.savefig(buffer, facecolor=NIGHT)
    plt.close(figure)
    return Image.open(buffer).convert("RGB")


def write_texts(figure: Figure, step: Step, pose: Floats) -> None:
    """Write title, time and legend, and the heading errors of the nearest fit, modulo 90 degrees, and track."""
    fit = heading_error(fit_poses(step), pose, plane.QUARTER)
    track = heading_error(track_poses(step), pose, 2 * np.pi)
    for y, text, style in (
        (0.945, "luxloop", {"color": TEXT, "fontsize": 17, "fontweight": "bold"}),
        (0.905, f"{SCENARIO} from above", {"color": TEXT, "fontsize": 10.5}),
        (0.875, f"{step.frame.time:4.1f} s", {"color": FAINT, "fontsize": 10.5}),
        (0.495, "close-up", {"color": TEXT, "fontsize": 10.5}),
        (0.46, "heading error of the fit", {"color": FAINT, "fontsize": 10}),
        (0.43, "heading error of the track", {"color": FAINT, "fontsize": 10}),
    ):
        figure.text(0.715, y, text, **style)
    for y, error in ((0.46, fit), (0.43, track)):
        figure.text(0.985, y, f"{np.degrees(error):.1f}\N{DEGREE SIGN}", color=FAINT, fontsize=10, ha="right")
    handles = [Line2D([], [], color=color, label=name, **style) for color, name, style in LEGEND]
    place = {"loc": "upper left", "bbox_to_anchor": (0.712, 0.845), "borderpad": 0, "labelspacing": 0.62}
    figure.legend(handles=handles, frameon=False, labelcolor=TEXT, fontsize=9.5, handlelength=1.6, **place)


def heading_error(poses: Floats, truth: Floats, period: float) -> float:
    """Return the absolute heading error of the pose nearest to the truth [rad]."""
    nearest = poses[np.linalg.norm(poses[:, :2] - truth[:2], axis=1).argmin()]
    return float(abs(plane.wrap(nearest[2] - truth[2], period)))


def fit_poses(step: Step) -> Floats:
    """Return the (N, 3) poses of the fitted boxes."""
    boxes = step.trace.boxes
    return plane.out_of_frame(np.column_stack([boxes.center_ego, boxes.heading]), step.frame.ego.pose_world)


def track_poses(step: Step) -> Floats:
    """Return the (N, 3) poses of the tracks."""
    in_odom = np.column_stack([step.tracks.center_odom, step.tracks.mean[:, 6]])
    return plane.out_of_frame(plane.into_frame(in_odom, step.scan.ego_pose_odom), step.frame.ego.pose_world)


def draw_town(axes: Axes, obstacles: Obstacles) -> None:
    """Draw the straight lanes of the net with their edges, the buildings, and a bar of 10 m."""
    net = ElementTree.parse(find(SCENARIO).parent / SCENARIO / "crossing.net.xml")
    for junction in net.iter("junction"):
        if shape := junction.get("shape"):
            axes.add_patch(Polygon(coordinates(shape), color=ROAD, linewidth=0))
    for lane in net.iterfind("edge[lane]/lane"):
        if not lane.attrib["id"].startswith(":") and lane.get("allow") != "pedestrian":
            begin, end = coordinates(lane.attrib["shape"])[[0, -1]]
            along = (end - begin) / np.linalg.norm(end - begin)
            side = 0.5 * float(lane.attrib["width"]) * np.array([-along[1], along[0]])
            axes.add_patch(Polygon([begin + side, end + side, end - side, begin - side], color=ROAD, linewidth=0))
            for edge in (side, -side):
                axes.plot(*np.transpose([begin + edge, end + edge]), color=HOUSE, linewidth=0.6, zorder=1)
    for house in np.split(obstacles.vertices_world, obstacles.offset[1:-1]):
        axes.add_patch(Polygon(house, color=HOUSE, linewidth=0))
    x, y = MAP_M[0] + 2.0, MAP_M[2] + 2.0
    axes.plot([x, x + 10.0], [y, y], color=TEXT, linewidth=2, zorder=9)
    axes.text(x + 5.0, y + 0.8, "10 m", color=TEXT, fontsize=8, ha="center", zorder=9)


def coordinates(shape: str) -> Floats:
    """Return the (N, 2) corners of a shape as SUMO writes it [m]."""
    return np.array([pair.split(",")[:2] for pair in shape.split()], dtype=float)


def draw_step(axes: Axes, step: Step, look: Look) -> None:
    """Draw points, truth, fits and tracks of one frame."""
    actors, ego = step.frame.actors, step.frame.ego
    points = plane.turned(step.scan.points_ego[:, :2].astype(np.float64), ego.pose_world[2]) + ego.pose_world[:2]
    on_actor = step.truth.actor_id != NO_ACTOR
    for mine, color, order in ((~on_actor, FAINT, 2), (on_actor, POINT, 8)):
        axes.scatter(*points[mine].T, s=look.point_size, c=color, linewidths=0, zorder=order)
    hidden = step.truth.visible_fraction < VISIBLE_MIN
    poses, sizes = actors.pose_world, actors.size[:, :2]
    draw_boxes(axes, poses[~hidden], sizes[~hidden], edgecolor=TRUTH, linewidth=look.line, zorder=6)
    dashed = {"edgecolor": HIDDEN, "linewidth": 1.2 * look.line, "linestyle": DASHES}
    draw_boxes(axes, poses[hidden], sizes[hidden], zorder=3, **dashed)
    draw_boxes(axes, fit_poses(step), step.trace.boxes.size, edgecolor=FIT, linewidth=1.6 * look.line, zorder=7)
    draw_tracks(axes, step, look)
    draw_boxes(axes, ego.pose_world[None], ego.size[None, :2], facecolor=EGO, edgecolor=EGO, zorder=6)
    write(axes, ego.pose_world[:2], "ego", look, color=NIGHT)


def draw_boxes(axes: Axes, poses: Floats, sizes: Floats, **style: Any) -> None:
    """Draw boxes with poses (N, 3) and sizes (N, 2), empty unless the style fills them."""
    corners = plane.corner(np.column_stack([poses, sizes])[:, None], plane.CORNER_SIGNS)
    axes.add_collection(PolyCollection(list(corners), **{"facecolor": "none", **style}))


def draw_tracks(axes: Axes, step: Step, look: Look) -> None:
    """Draw the confirmed tracks, each with a line of one second of its motion, its id and its speed."""
    tracks, poses = step.tracks, track_poses(step)
    velocities = plane.turned(tracks.mean[:, 2:4], step.frame.ego.pose_world[2] - step.scan.ego_pose_odom[2])
    for row in np.flatnonzero(tracks.status == Status.CONFIRMED):
        color, velocity = TRACKS[tracks.id[row] % len(TRACKS)], velocities[row]
        style = {"facecolor": f"{color}38", "edgecolor": color, "linewidth": 2.4 * look.line}
        draw_boxes(axes, poses[row, None], tracks.size[row, None], zorder=5, **style)
        write(axes, poses[row, :2], str(tracks.id[row]), look, color=TEXT, **BOLD)
        speed = float(np.hypot(*velocity))
        if speed > MOVES_MPS:
            front = poses[row, :2] + 0.5 * tracks.size[row, 0] * velocity / speed
            axes.plot(*np.transpose([front, front + velocity]), color=color, linewidth=1.4, zorder=5)
            write(axes, front + velocity, f"{speed:.0f} m/s", look, color=color, **BOLD)


def write(axes: Axes, at: Floats, text: str, look: Look, **style: Any) -> None:
    """Write a text on the map; the close-up has none."""
    if look.text_size:
        axes.text(*at, text, fontsize=look.text_size, ha="center", va="center", zorder=9, clip_on=True, **style)
