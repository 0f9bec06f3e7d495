"""Windows seen over a hood or a deck: pieces of the vehicle before them, not vehicles of their own."""

from dataclasses import dataclass

import numpy as np

from tracker.geometry import rotate
from tracker.records import Bools, Boxes, Floats

CORNERS = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])


@dataclass(frozen=True, slots=True)
class ShadowConfig:
    """What counts as seen over something nearer."""

    depth_m: float = 2.5
    """A piece this close behind a nearer box, and no wider, belongs to it [m]; a hood is 1 to 1.5 m long."""
    outside_rad: float = 0.01
    """How far a piece may stick out of the nearer box as seen from the ego [rad]."""


def in_shadow(boxes: Boxes, config: ShadowConfig) -> Bools:
    """(B,) whether a box lies right behind another as seen from the ego.

    No other vehicle could be seen there: the nearer one would hide it, were it not the nearer one's own top.
    """
    half = 0.5 * CORNERS[None] * boxes.size[:, None]
    corners = boxes.center_ego[:, None] + rotate(half, boxes.heading[:, None])
    nearest = np.hypot(*boxes.corner_ego.T)
    bearing = np.arctan2(boxes.center_ego[:, 1], boxes.center_ego[:, 0])
    depth = nearest[None] - nearest[:, None]
    behind = (depth > 0) & (depth < config.depth_m)
    low, high = spread(corners, bearing)
    own = np.diagonal(low), np.diagonal(high)
    covered = (low >= own[0][:, None] - config.outside_rad) & (high <= own[1][:, None] + config.outside_rad)
    return np.asarray(np.any(behind & covered, axis=0))


def spread(corners: Floats, bearing: Floats) -> tuple[Floats, Floats]:
    """(B, B) lowest and highest azimuth of the corners (B, 4, 2) of box j, from the bearing (B,) of box i."""
    azimuth = np.arctan2(corners[..., 1], corners[..., 0])
    off = (azimuth[None] - bearing[:, None, None] + np.pi) % (2 * np.pi) - np.pi
    return off.min(axis=2), off.max(axis=2)
