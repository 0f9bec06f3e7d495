"""Windows seen over a hood or a deck: pieces of the vehicle before them, not vehicles of their own."""

from dataclasses import dataclass

import numpy as np

from tracker.arrays import Bools
from tracker.geometry import inside, rotate
from tracker.records import Boxes


@dataclass(frozen=True, slots=True)
class SuppressionConfig:
    """What counts as seen over something nearer."""

    depth_m: float = 2.5
    """A piece this close behind a face belongs to it [m]: a hood is 1 to 1.5 m long, a windscreen as deep again."""
    side_min_m: float = 1.5
    """A box less deep than this shows one face only; what is behind it is unknown [m]."""
    margin_m: float = 0.2
    """How far the middle of a piece may lie outside the nearer box [m]."""


def in_shadow(boxes: Boxes, config: SuppressionConfig) -> Bools:
    """(B,) whether a box lies inside another that is nearer to the ego, or right behind its only seen face.

    No other vehicle can be there: the nearer one takes the place.
    """
    depth = np.where(boxes.size < config.side_min_m, config.depth_m, 0.0)
    away = rotate(-0.5 * boxes.corner_sign * depth, boxes.heading)
    covered = inside(boxes.center_ego, boxes.center_ego + away, boxes.heading, boxes.size + depth + 2 * config.margin_m)
    range_m = np.hypot(*boxes.corner_ego.T)
    return np.asarray(np.any(covered & (range_m[:, None] > range_m), axis=1))
