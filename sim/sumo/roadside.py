"""Static obstacles from SUMO's polygons and points of interest."""

import re
from typing import Any

import numpy as np

from luxloop.arrays import Floats
from luxloop.sim.obstacles import DEFAULTS, Prism, StreetKind, build, obstacles
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Obstacles

KIND_BY_TYPE: dict[str, StreetKind] = {
    "building": "building",
    "wall": "wall",
    "retaining_wall": "wall",
    "noise_barrier": "wall",
    "hedge": "wall",
    "barrier": "barrier",
    "jersey_barrier": "barrier",
    "fence": "fence",
    "guard_rail": "guard-rail",
    "pole": "pole",
    "street_lamp": "pole",
    "tree": "tree",
    "traffic_sign": "traffic-sign",
    "bollard": "bollard",
}
"""Kind by a word of the type, which are OpenStreetMap's values; of `barrier.guard_rail` the last known word counts."""

PARAMETERS = ("height", "base", "diameter", "reflectivity")
"""Parameters of a shape, see `luxloop.sim.obstacles.build`."""

STOREY = 3.0
"""[m] Storey height of buildings with `building:levels` but without height, as in OpenStreetMap."""

_METRES = re.compile(r"\s*([-+.\d]+(?:e[-+]?\d+)?)\s*m?\s*", re.IGNORECASE)
"""A number with or without OpenStreetMap's unit."""


def static_obstacles(polygon: Any, poi: Any, building_height: float) -> Obstacles:
    """Return the static obstacles among the loaded shapes.

    Parameters
    ----------
    polygon, poi
        libsumo's domains of polygons and of points of interest.
    building_height
        Default height of buildings [m].

    Raises
    ------
    TrafficInputError
        A shape has too few points, or an invalid parameter.
    """
    prisms: list[Prism] = []
    for name in sorted(polygon.getIDList()):
        prisms += _of_polygon(polygon, name, building_height)
    for name in sorted(poi.getIDList()):
        prisms += _of_point(poi, name)
    return obstacles(prisms)


def _of_polygon(polygon: Any, name: str, building_height: float) -> list[Prism]:
    """Convert a polygon: the course of a wall, or the outline of a building, a pole or any shape with a height."""
    label, points = f'polygon "{name}"', np.array(polygon.getShape(name))[:, :2]
    sizes = _sizes(label, polygon, name)
    kind = _kind(polygon.getType(name)) or ("building" if "height" in sizes else None)
    if kind is None or np.all(points == points[0]):  # flat, or degenerate at the edge of a map extract
        return []
    if DEFAULTS[kind].form != "line":
        if kind == "building" and (levels := polygon.getParameter(name, "building:levels")):
            building_height = STOREY * _number(label, "building:levels", levels)
        sizes.setdefault("height", building_height if kind == "building" else DEFAULTS[kind].height)
        kind, points = "building", _without_closing_corner(points)
    return _build(label, kind, points, sizes)


def _of_point(poi: Any, name: str) -> list[Prism]:
    """Convert a point of interest to a pole or a similar obstacle."""
    label, points = f'point of interest "{name}"', np.array([poi.getPosition(name)[:2]])
    sizes = _sizes(label, poi, name)
    kind = _kind(poi.getType(name))
    if kind is None or DEFAULTS[kind].form != "places":
        kind = "pole" if "height" in sizes else None
    return _build(label, kind, points, sizes) if kind else []


def _kind(type_name: str) -> StreetKind | None:
    """Return the kind for a shape's type, None if unknown."""
    words = type_name.replace("-", "_").split(".")
    known = [KIND_BY_TYPE[word] for word in words if word in KIND_BY_TYPE]
    if known:
        return known[-1]
    return "building" if type_name.startswith("building") else None


def _without_closing_corner(points: Floats) -> Floats:
    """Remove the last corner of an outline if it repeats the first."""
    return points[:-1] if len(points) > 2 and np.array_equal(points[0], points[-1]) else points


def _sizes(label: str, shapes: Any, name: str) -> dict[str, float]:
    """Return the `PARAMETERS` that a shape has."""
    texts = {key: shapes.getParameter(name, key) for key in PARAMETERS}
    return {key: _number(label, key, text) for key, text in texts.items() if text}


def _number(label: str, key: str, text: str) -> float:
    try:
        return float(_METRES.sub(r"\1", text))
    except ValueError:
        raise TrafficInputError(f'{label}: {key} = "{text}"; write a number') from None


def _build(label: str, kind: StreetKind, points: Floats, sizes: dict[str, float]) -> list[Prism]:
    try:
        return build(kind, points, **sizes)
    except ValueError as error:
        raise TrafficInputError(f"{label}: {error}") from error
