"""Terrain around roads: the heights of the lanes, continued into the surroundings."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Bools, Floats
from luxloop.sim.world import Terrain

CELL_M = 2.0
"""[m] Distance of the terrain's nodes: half a car's length, so that a kink of the road stays within 3 cm at 6 %."""
NODES_MAX = 4_000_000
"""Larger nets have larger cells, in powers of two."""
REACH_M = 40.0
"""[m] Lanes farther away than this do not affect a node."""
DECK_M = 3.0
"""[m] A lane this far above another is on a bridge there."""

_NEAR_M = 12.0  # distance within which lanes are one above the other
_LEAST_M = 0.01  # distance in place of smaller ones
_POWER = 4  # of the inverse distance


@dataclass(frozen=True, slots=True, eq=False)
class LaneSections:
    """S straight sections of lanes in the world frame."""

    ends: Floats
    """(S, 2, 3) x, y, z of both ends [m]."""
    half_width: Floats
    """(S,) [m]."""


def road_terrain(sections: LaneSections) -> tuple[Terrain, int]:
    """Return the terrain around lanes, and the number of its nodes on which one lane passes above another.

    A node on a lane has the lane's height, constant across it. Off the lanes, it has the mean of the sections within
    `REACH_M`, each at its nearest point, weighted by a power of the inverse distance from the lane's edge that falls to
    0 at `REACH_M` (Shepard 1968, with the weights of Franke and Nielson 1980); farther off, the height of the nearest
    node with lanes around. Where lanes are one above the other, the ground is the lowest: bridges have no surface.
    """
    from scipy.ndimage import distance_transform_edt

    corner, cell, shape = _grid(sections.ends)
    low = np.full(shape, np.inf)
    for section in _sections(sections, corner, cell, shape):
        near = section.distance < _NEAR_M
        low[section.window] = np.where(near, np.minimum(low[section.window], section.height), low[section.window])
    weight, sum_, decks = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=np.bool_)
    for section in _sections(sections, corner, cell, shape):
        above = (section.distance < _NEAR_M) & (section.height > low[section.window] + DECK_M)
        decks[section.window] |= above & (section.distance <= _LEAST_M)
        share = np.where(above, 0.0, section.weight)
        weight[section.window] += share
        sum_[section.window] += share * section.height
    known: Bools = weight > 0.0
    height = np.divide(sum_, weight, out=np.zeros(shape), where=known)
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return Terrain(corner, cell, height[tuple(nearest)]), int(decks.sum())


@dataclass(frozen=True, slots=True, eq=False)
class _SectionOnGrid:
    """Section of a lane on the nodes within its reach."""

    window: tuple[slice, slice]
    distance: Floats
    """From the lane's edge [m], at least `_LEAST_M`."""
    height: Floats
    """Of the section's nearest point [m]."""

    @property
    def weight(self) -> Floats:
        """Weight of the section at each node."""
        share: Floats = np.maximum(REACH_M - self.distance, 0.0) / (REACH_M * self.distance)
        return share**_POWER


def _grid(ends: Floats) -> tuple[Floats, float, tuple[int, int]]:
    """Return first corner, cell size and shape of the grid; its nodes are at multiples of the cell size."""
    low, high = ends[..., :2].min(axis=(0, 1)) - REACH_M, ends[..., :2].max(axis=(0, 1)) + REACH_M
    cell = CELL_M
    while math.prod((high - low) / cell + 2.0) > NODES_MAX:
        cell *= 2.0
    first, last = np.floor(low / cell), np.ceil(high / cell)
    columns, rows = (last - first).astype(int) + 1
    return first * cell, cell, (int(columns), int(rows))


def _sections(sections: LaneSections, corner: Floats, cell: float, shape: tuple[int, int]) -> Iterator[_SectionOnGrid]:
    """Yield the sections, each on the nodes within `REACH_M` of it."""
    limit = np.array(shape)
    for (start, end), half_width in zip(sections.ends, sections.half_width, strict=True):
        reach = REACH_M + half_width
        low = np.floor((np.minimum(start, end)[:2] - reach - corner) / cell).astype(int)
        high = np.ceil((np.maximum(start, end)[:2] + reach - corner) / cell).astype(int) + 1
        low, high = np.clip(low, 0, limit), np.clip(high, 0, limit)
        x = corner[0] + cell * np.arange(low[0], high[0])[:, None] - start[0]
        y = corner[1] + cell * np.arange(low[1], high[1]) - start[1]
        (dx, dy), rise = (end - start)[:2], end[2] - start[2]
        square = dx * dx + dy * dy
        along = np.clip((x * dx + y * dy) / square, 0.0, 1.0) if square > 0.0 else np.zeros((len(x), len(y)))
        distance = np.maximum(elementwise.hypot(x - along * dx, y - along * dy) - half_width, _LEAST_M)
        yield _SectionOnGrid((slice(low[0], high[0]), slice(low[1], high[1])), distance, start[2] + along * rise)


WHEELBASE_SHARE = 0.6
"""Share of a body's length between its points of contact: the wheelbase of cars is 0.55 to 0.65 of their length."""
TRACK_SHARE = 0.85
"""Share of a body's width between its wheels: 1.55 m of 1.8 m for a car."""
BRIDGE_M = 0.3
"""[m] A simulator's road this far above a wheel's ground is a bridge: more than half a wheelbase at 15 % explains."""


def ground_contact(terrain: Terrain, pose_world: Floats, size: Floats, road: Floats | None) -> tuple[Floats, Floats]:
    """Return height and slope of the planes on which N bodies stand.

    Each stands on four points. The height under its centre is their mean; pitch and roll are the slopes between their
    pairs, so that a body passes a kink of the road gradually. A body on a bridge, which the terrain does not contain,
    takes the height and slope of the simulator's road.

    Parameters
    ----------
    terrain
        Height of the ground.
    pose_world, size
        (N, 3) x [m], y [m], yaw [rad]; (N, 3) length, width, height [m].
    road
        (N, 2) as in `kinematics.RawFrame`.

    Returns
    -------
    (N,) height [m]; (N, 2) pitch, positive with the front down, and roll, positive with the right side down [rad].
    """
    cos, sin = elementwise.cos(pose_world[:, 2]), elementwise.sin(pose_world[:, 2])
    ahead = 0.5 * WHEELBASE_SHARE * size[:, :1] * np.column_stack([cos, sin])
    aside = 0.5 * TRACK_SHARE * size[:, 1:2] * np.column_stack([-sin, cos])
    middle = pose_world[:, :2]
    front_left, front_right, rear_left, rear_right = (
        terrain.height_at(middle + along * ahead + across * aside) for along in (1, -1) for across in (1, -1)
    )
    rise = 0.5 * (front_left + front_right - rear_left - rear_right)
    bank = 0.5 * (front_left + rear_left - front_right - rear_right)
    height = 0.25 * (front_left + front_right + rear_left + rear_right)
    pitch, roll = (
        -elementwise.atan2(rise, 2.0 * elementwise.hypot(*ahead.T)),
        elementwise.atan2(bank, 2.0 * elementwise.hypot(*aside.T)),
    )
    if road is not None:
        lowest = np.minimum.reduce([front_left, front_right, rear_left, rear_right])
        on_deck = road[:, 0] > lowest + BRIDGE_M  # False for NaN
        height = np.where(on_deck, road[:, 0], height)
        pitch, roll = np.where(on_deck, -road[:, 1], pitch), np.where(on_deck, 0.0, roll)
    return height, np.column_stack([pitch, roll])
