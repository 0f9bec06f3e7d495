"""Suppression of boxes behind a visible face: windows above a hood or a deck are parts of the nearer vehicle."""

from dataclasses import dataclass

import numpy as np

from luxloop.tracker.arrays import Bools
from luxloop.tracker.geometry import inside, rotate
from luxloop.tracker.records import Boxes


@dataclass(frozen=True, slots=True)
class SuppressionConfig:
    """Extent of the suppressed area behind a face."""

    depth_m: float = 2.5
    """Depth behind a face within which a box is a part of it [m]: a hood is 1 to 1.5 m long, a windscreen as deep."""
    side_min_m: float = 1.5
    """A box less deep than this shows a single face, and its true depth is unknown [m]."""
    margin_m: float = 0.2
    """Margin around the nearer box for the centre of a part [m]."""


def in_shadow(boxes: Boxes, config: SuppressionConfig) -> Bools:
    """(B,) mask of boxes inside another box that is nearer to the ego, or right behind its only visible face.

    The nearer vehicle occupies that area.
    """
    depth = np.where(boxes.size < config.side_min_m, config.depth_m, 0.0)
    away = rotate(-0.5 * boxes.corner_sign * depth, boxes.heading)
    covered = inside(boxes.center_ego, boxes.center_ego + away, boxes.heading, boxes.size + depth + 2 * config.margin_m)
    range_m = np.hypot(*boxes.corner_ego.T)
    return np.asarray(np.any(covered & (range_m[:, None] > range_m), axis=1))
