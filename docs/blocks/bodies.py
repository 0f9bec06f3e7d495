"""Draw the bodies of all kinds of road users in the ray caster, coloured by the parts of their surfaces."""

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.patches import Patch
from PIL import Image

from luxloop.sensor_model.bodies.articulation import rotate_boxes, rotate_planes
from luxloop.sensor_model.bodies.body import Appearance, Body, build
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.shapes import SHAPES
from luxloop.sensor_model.truth import Part
from luxloop.sim.articulation import hitch
from luxloop.sim.world import Kind

Floats = npt.NDArray[np.float64]

PICTURE = Path(__file__).parents[1] / "pictures" / "bodies.png"
COLORS = {
    Part.BODY: (0.62, 0.70, 0.80),
    Part.GREENHOUSE: (0.25, 0.45, 0.60),
    Part.MIRROR: (0.85, 0.20, 0.65),
    Part.WHEEL: (0.25, 0.25, 0.25),
}
LIGHT = np.array([0.30, -0.50, 0.81])
AROUND = 0.25
"""Margin around a body [m]."""
PIXELS = 320
"""Pixels along the longer side of a view."""
SEED = 1
BENT = 0.6
"""Articulation of the truck in the last row, to the left [rad]."""
VIEWS = (
    # title, viewing direction, actor (None is the middle of all ranges)
    ("side, middle of the ranges", (0.0, 1.0, 0.0), None),
    ("front, middle of the ranges", (-1.0, 0.0, 0.0), None),
    ("plan, middle of the ranges", (0.0, 0.0, -1.0), None),
    ("from the front, actor 1", (-0.75, 0.60, -0.35), 1),
    ("from the rear, actor 2", (0.75, 0.60, -0.35), 2),
    ("from the rear, actor 3", (0.75, 0.60, -0.35), 3),
)


def first_planes(body: Body, origins: Floats, direction: Floats) -> npt.NDArray[np.int64]:
    """Return the (N,) first plane of the outer solids hit by each of N parallel rays, -1 without a hit."""
    nearest, plane = np.full(len(origins), np.inf), np.full(len(origins), -1)
    ends = np.cumsum([0, *body.planes_of_solid])
    for solid in np.flatnonzero(~body.solid_inner):
        rows = slice(ends[solid], ends[solid + 1])
        normals, offsets = body.planes[rows, :3], body.planes[rows, 3]
        slant, ahead = normals @ direction, offsets - origins @ normals.T
        slant = np.where(slant == 0.0, -1e-12, slant)  # parallel to the plane
        at = ahead / slant
        enters = np.where(slant < 0.0, at, -np.inf)
        leaves = np.where(slant > 0.0, at, np.inf)
        start = enters.max(axis=1)
        met = (start < leaves.min(axis=1)) & (start < nearest)
        nearest[met] = start[met]
        plane[met] = ends[solid] + enters.argmax(axis=1)[met]
    return plane


def bent(body: Body, length: float, articulation: float) -> Body:
    """Return an articulated body with its tractor rotated [rad]."""
    kingpin = 0.5 * length - float(hitch(np.array([length])).kingpin[0])
    pivot = np.array([[kingpin, kingpin, 0.0]])
    solid = np.where(body.solid_ahead > 0, articulation, 0.0)
    plane = np.repeat(solid, body.planes_of_solid)
    boxes = rotate_boxes(body.solid_bounds, pivot.repeat(len(solid), axis=0), solid)
    return replace(
        body,
        bounds=np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]),
        solid_bounds=boxes,
        planes=rotate_planes(body.planes, pivot.repeat(len(plane), axis=0), plane),
    )


def picture(body: Body, sight: Floats) -> tuple[Floats, tuple[float, float]]:
    """Pixels (rows, columns, 3) of a view from far away, and its width and height [m]."""
    right = np.cross(sight, [0.0, 0.0, 1.0]) if abs(sight[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, sight)
    box = np.stack(np.meshgrid(*body.bounds.T), axis=-1).reshape(-1, 3)
    u, v = box @ right, box @ up
    u0, u1, v0, v1 = u.min() - AROUND, u.max() + AROUND, v.min() - AROUND, v.max() + AROUND
    step = max(u1 - u0, v1 - v0) / PIXELS
    columns, rows = np.meshgrid(np.arange(u0, u1, step), np.arange(v1, v0, -step))
    origins = columns[..., None] * right + rows[..., None] * up - 100.0 * sight
    plane = first_planes(body, origins.reshape(-1, 3), sight).reshape(columns.shape)

    colors = np.array([COLORS.get(Part(part), (1.0, 1.0, 1.0)) for part in body.plane_part])
    shade = 0.65 + 0.35 * np.clip(body.planes[:, :3] @ LIGHT, -1.0, 1.0)
    pixels = np.where(plane[..., None] >= 0, (colors * shade[:, None])[plane], 1.0)
    edge = np.zeros(plane.shape, dtype=np.bool_)
    edge[1:] |= plane[1:] != plane[:-1]
    edge[:, 1:] |= plane[:, 1:] != plane[:, :-1]
    pixels[edge] *= 0.45
    return pixels, (u1 - u0, v1 - v0)


def draw(_name: str) -> None:
    """Write the picture: a row for each kind, a column for each view."""
    shown = [(kind, 0.0) for kind in Kind if kind is not Kind.OBSTACLE] + [(Kind.TRAILER_TRUCK, BENT)]
    figure, table = plt.subplots(len(shown), len(VIEWS), figsize=(22, 2.6 * len(shown)), layout="constrained")
    for (kind, articulation), row in zip(shown, table, strict=True):
        for axes, (_, sight, actor) in zip(row, VIEWS, strict=True):
            appearance = Appearance(f"car {actor}", kind, SHAPES[kind].size, paint=0.4)
            draw = Draw(None if actor is None else SEED, appearance.name)
            body = build(appearance, draw, Glass(), mirrors=True, as_prism=False)
            if articulation:
                body = bent(body, appearance.size[0], articulation)
            pixels, (width, height) = picture(body, np.array(sight) / np.linalg.norm(sight))
            axes.imshow(pixels, extent=(0.0, width, 0.0, height))
            axes.set_axis_off()
        solids, planes = len(body.solid_inner), len(body.planes)
        name = kind.name.lower().replace("_", " ") + (", bent" if articulation else "")
        label = f"{name}\n{solids} solids, {planes} planes"
        row[0].text(-0.02, 0.5, label, rotation=90, ha="right", va="center", transform=row[0].transAxes)
    for axes, (title, _, _) in zip(table[0], VIEWS, strict=True):
        axes.set_title(title)
    names = {Part.BODY: "painted", Part.GREENHOUSE: "glass", Part.MIRROR: "mirror", Part.WHEEL: "rubber"}
    figure.legend(
        handles=[Patch(color=COLORS[part], label=name) for part, name in names.items()],
        loc="outside lower right",
        ncols=4,
    )
    figure.savefig(PICTURE, dpi=70)
    with Image.open(PICTURE) as drawn:
        drawn.convert("RGB").quantize(128).save(PICTURE, optimize=True)  # flat colours: a third of the size
