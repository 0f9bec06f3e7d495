"""Adaptive segmentation (Zhang 2017): connect points within a radius that grows with range."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.detection.kernels import groups
from luxloop.tracker.detection.kernels.chains import connected
from luxloop.tracker.records import NOT_USED, Segments


@dataclass(frozen=True, slots=True)
class SegmentationConfig:
    """Connection radius of a point: radius_m + radius_per_m * range.

    The beams of a layer are 0.5 degrees apart, the two pairs interleave to 0.25 (IBEO LUX): 0.17 m at 40 m on a
    perpendicular surface, 0.7 m on a side at 15 degrees. Cars in adjacent lanes are 1.4 to 1.7 m apart, queued cars
    2 m. The default radius is 0.7 m at 10 m and 1.3 m at 40 m.
    """

    radius_m: float = 0.5
    """Radius at the ego [m]; must also bridge a side mirror (0.2 m)."""
    radius_per_m: float = 0.02
    """Growth of the radius with range, dimensionless."""
    points_min: int = 5
    """Smaller segments are dropped: a rectangle has five parameters."""

    def __post_init__(self) -> None:
        if self.radius_m <= 0.0 or self.radius_per_m < 0.0:
            raise ValueError("radius_m must be positive and radius_per_m not negative")
        if self.points_min < 2:
            raise ValueError(f"points_min is {self.points_min}; a segment needs at least 2 points to have a direction")


def segment(points_ego: npt.NDArray[np.floating], keep: Bools, config: SegmentationConfig) -> Segments:
    """Group the kept points (N, 2 or more columns) into connected components of pairs within either point's radius.

    Segments are numbered by their first point. The components equal those of a KD-tree search over all pairs; points
    are first binned into cells no wider than the smallest radius, so that a dense cluster needs no search.
    """
    used = np.flatnonzero(keep)
    first = connect(positions(points_ego, used), config)
    kept = np.bincount(first, minlength=len(used)) >= config.points_min
    label = np.full(len(points_ego), NOT_USED, dtype=np.int64)
    label[used] = np.where(kept, np.cumsum(kept) - 1, NOT_USED)[first]
    return Segments(label=label, count=int(kept.sum()))


def positions(points_ego: npt.NDArray[np.floating], index: Ints) -> Floats:
    """(K, 2) x and y of the points of `index` (K,) [m], for kernels."""
    found: Floats = groups.positions(np.asarray(points_ego, dtype=np.float64, order="C"), index)
    return found


def connect(points: Floats, config: SegmentationConfig) -> Ints:
    """(N,) index of the first point of each point's component."""
    if not len(points):
        return np.empty(0, dtype=np.int64)
    return connected(points, config.radius_m, config.radius_per_m)


def by_segment(segments: Segments) -> tuple[Ints, Ints]:
    """Return the indices of used points by segment and in scan order, and the start (S + 1,) of each segment."""
    return groups.by_group(segments.label, segments.count)


def keep_only(segments: Segments, kept: Bools) -> Segments:
    """Drop the segments that are not `kept` (S,), and renumber the others in the same order."""
    number = np.append(np.where(kept, np.cumsum(kept) - 1, NOT_USED), NOT_USED)
    return Segments(label=number[segments.label], count=int(kept.sum()))
