"""Draw the bodies of all kinds of road users in the ray caster, coloured by the parts of their surfaces."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch
from PIL import Image

from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.bodies.body import Appearance, Body, build
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.shapes import SHAPES
from luxloop.sensor_model.truth import Part
from luxloop.sim.world import Kind

PICTURE = Path(__file__).parents[1] / "pictures" / "bodies.png"
MATERIALS = {
    Part.BODY: ("painted", (0.62, 0.70, 0.80)),
    Part.GREENHOUSE: ("glass", (0.25, 0.45, 0.60)),
    Part.MIRROR: ("mirror", (0.85, 0.20, 0.65)),
    Part.WHEEL: ("rubber", (0.25, 0.25, 0.25)),
}
LIGHT = np.array([0.30, -0.50, 0.81])
AROUND_M, PIXELS = 0.25, 320
"""Margin around a body, and pixels along the longer side of a view."""
VIEWS = (
    # title, viewing direction, actor (None is the middle of all ranges)
    ("side, middle of the ranges", (0.0, 1.0, 0.0), None),
    ("front, middle of the ranges", (-1.0, 0.0, 0.0), None),
    ("plan, middle of the ranges", (0.0, 0.0, -1.0), None),
    ("from the front, actor 1", (-0.75, 0.60, -0.35), 1),
    ("from the rear, actor 2", (0.75, 0.60, -0.35), 2),
)


def draw(_name: str) -> None:
    """Write the picture: a row for each kind, a column for each view."""
    kinds = [kind for kind in Kind if kind is not Kind.OBSTACLE]
    figure, table = plt.subplots(len(kinds), len(VIEWS), figsize=(18.5, 2.6 * len(kinds)), layout="constrained")
    for kind, row in zip(kinds, table, strict=True):
        for axes, (title, sight, actor) in zip(row, VIEWS, strict=True):
            appearance = Appearance(f"car {actor}", kind, SHAPES[kind].size, paint=0.4)
            drawn = Draw(None if actor is None else 1, appearance.name)
            body = build(appearance, drawn, Glass(), mirrors=True, as_prism=False)
            axes.imshow(view(body, np.array(sight) / np.linalg.norm(sight)))
            axes.set_axis_off()
            if kind is kinds[0]:
                axes.set_title(title)
        name = f"{kind.name.lower().replace('_', ' ')}\n{len(body.solid_inner)} solids, {len(body.planes)} planes"
        row[0].text(-0.02, 0.5, name, rotation=90, ha="right", va="center", transform=row[0].transAxes)
    handles = [Patch(color=color, label=name) for name, color in MATERIALS.values()]
    figure.legend(handles=handles, loc="outside lower right", ncols=4)
    figure.savefig(PICTURE, dpi=70)
    Image.open(PICTURE).convert("RGB").quantize(128).save(PICTURE, optimize=True)  # flat colours: a third of the size


def view(body: Body, sight: Floats) -> Floats:
    """Return the pixels (rows, columns, 3) of a view from far away, shaded and with edges."""
    right = np.cross(sight, [0.0, 0.0, 1.0]) if abs(sight[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, sight)
    corners = np.stack(np.meshgrid(*body.bounds.T), axis=-1).reshape(-1, 3) @ np.column_stack([right, up])
    (u0, v0), (u1, v1) = corners.min(axis=0) - AROUND_M, corners.max(axis=0) + AROUND_M
    step = max(u1 - u0, v1 - v0) / PIXELS
    columns, rows = np.meshgrid(np.arange(u0, u1, step), np.arange(v1, v0, -step))
    origins = columns[..., None] * right + rows[..., None] * up - 100.0 * sight
    plane = first_planes(body, origins.reshape(-1, 3), sight).reshape(columns.shape)
    colors = np.array([MATERIALS.get(Part(part), ("", (1.0, 1.0, 1.0)))[1] for part in body.plane_part])
    shade = 0.65 + 0.35 * np.clip(body.planes[:, :3] @ LIGHT, -1.0, 1.0)
    pixels = np.where(plane[..., None] >= 0, (colors * shade[:, None])[plane], 1.0)
    pixels[1:][plane[1:] != plane[:-1]] *= 0.45
    pixels[:, 1:][plane[:, 1:] != plane[:, :-1]] *= 0.45
    return pixels


def first_planes(body: Body, origins: Floats, direction: Floats) -> Ints:
    """Return the (N,) first plane of the outer solids hit by each of N parallel rays, -1 without a hit."""
    nearest, plane = np.full(len(origins), np.inf), np.full(len(origins), -1)
    ends = np.cumsum([0, *body.planes_of_solid])
    for solid in np.flatnonzero(~body.solid_inner):
        rows = slice(ends[solid], ends[solid + 1])
        normals, offsets = body.planes[rows, :3], body.planes[rows, 3]
        slant = normals @ direction
        slant = np.where(slant == 0.0, -1e-12, slant)  # parallel to the plane
        at = (offsets - origins @ normals.T) / slant
        enters = np.where(slant < 0.0, at, -np.inf)
        start = enters.max(axis=1)
        met = (start < np.where(slant > 0.0, at, np.inf).min(axis=1)) & (start < nearest)
        nearest[met] = start[met]
        plane[met] = ends[solid] + enters.argmax(axis=1)[met]
    return plane
