"""Rerun archetypes of boxes, texts, walls and rings, from numpy arrays in metres and radians.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.world import Obstacles

if TYPE_CHECKING:
    import rerun as rr

Color = tuple[int, int, int]


def flat(xy: Floats) -> Floats:
    """Return points (N, 3) on the ground, z = 0, from `xy` (N, 2)."""
    return np.column_stack([xy, np.zeros(len(xy))])


def transform(pose: Floats) -> "rr.Transform3D":
    """Return the transform of a frame on the ground with `pose` (3,) x [m], y [m], yaw [rad] in its parent."""
    import rerun as rr

    yaw = rr.RotationAxisAngle(axis=(0, 0, 1), radians=pose[2])
    return rr.Transform3D(translation=[pose[0], pose[1], 0.0], rotation=yaw)


def boxes(
    pose: Floats,
    size: Floats,
    colors: Floats | Color,
    *,
    labels: list[str] | None = None,
    show_labels: bool = True,
    line_ui: float | Floats = 0.75,
    solid: bool = False,
) -> "rr.Boxes3D":
    """Return boxes on the ground.

    Parameters
    ----------
    pose
        (N, 3) x [m], y [m], yaw [rad].
    size
        (N, 3) length, width and height [m].
    colors
        One colour, or (N, 3), 0 to 255.
    labels
        Text of each box.
    show_labels
        False shows labels on mouse hover only.
    line_ui
        Half width of the edges, scalar or (N,) [screen points].
    solid
        True fills the boxes; otherwise only edges are drawn.
    """
    import rerun as rr

    half_yaw = 0.5 * pose[:, 2]
    zero = np.zeros_like(half_yaw)
    return rr.Boxes3D(
        centers=np.column_stack([pose[:, :2], 0.5 * size[:, 2]]),
        half_sizes=0.5 * size,
        quaternions=np.column_stack([zero, zero, np.sin(half_yaw), np.cos(half_yaw)]),
        colors=np.asarray(colors, dtype=np.uint8),
        labels=labels,
        show_labels=show_labels,
        radii=rr.Radius.ui_points(line_ui),
        fill_mode="solid" if solid else "majorwireframe",
    )


def texts(xy: Floats, labels: list[str]) -> "rr.Points3D":
    """Return `labels` at `xy` (N, 2) on the ground [m], in white: the viewer puts them on mid grey."""
    import rerun as rr

    return rr.Points3D(flat(xy), labels=labels, show_labels=True, radii=0.0, colors=(255, 255, 255))


def walls(obstacles: Obstacles, origin_world: Floats, top_m: float, color: Color) -> "rr.Mesh3D":
    """Return the walls of polygons relative to `origin_world` (2,) [m], clipped at `top_m`: two triangles each."""
    import rerun as rr

    quads = [np.empty((0, 4, 3))]
    for base, height, (start, stop) in zip(obstacles.base, obstacles.height, pairwise(obstacles.offset), strict=True):
        outline = flat(obstacles.vertices_world[start:stop] - origin_world)
        foot, top = (outline + np.array([0.0, 0.0, min(z, top_m)]) for z in (base, height))
        quads.append(np.stack([foot, np.roll(foot, -1, axis=0), np.roll(top, -1, axis=0), top], axis=1))
    corners = np.concatenate(quads)
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    return rr.Mesh3D(
        vertex_positions=corners.reshape(-1, 3),
        triangle_indices=(4 * np.arange(len(corners))[:, None, None] + halves).reshape(-1, 3),
        albedo_factor=color,
    )


def rings(radii_m: tuple[float, ...], color: Color) -> "rr.LineStrips3D":
    """Return circles around the origin."""
    import rerun as rr

    angle = np.linspace(0.0, 2.0 * np.pi, 121)
    circle = flat(np.column_stack([np.cos(angle), np.sin(angle)]))
    return rr.LineStrips3D([radius * circle for radius in radii_m], colors=color, radii=rr.Radius.ui_points(0.5))
