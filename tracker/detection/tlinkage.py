"""T-linkage (algorithm 1): lines, outliers and dominant direction of each segment."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Floats
from luxloop.tracker.bounds import require_within
from luxloop.tracker.detection.kernels.bearings import even_subset
from luxloop.tracker.detection.kernels.line_labels import label_lines
from luxloop.tracker.detection.kernels.linkage import link_samples
from luxloop.tracker.detection.linked_faces import label_faces
from luxloop.tracker.detection.segmentation import by_segment
from luxloop.tracker.geometry import fold
from luxloop.tracker.records import Linkage, Segments

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True, slots=True)
class LinkageConfig:
    """Scales of the linkage, and conditions for lines."""

    variant: Literal["faces", "lines", "paper"] = "faces"
    """Use of T-linkage's clusters. `paper`: clusters before the largest jump in size are lines, all other points
    outliers. `lines`: clusters unlikely to arise by chance are lines, at any angle. `faces`: clusters propose the two
    perpendicular faces of a vehicle; points outside these or well inside are outliers."""
    tau_m: float = 0.08
    """Inlier threshold of equation (1) [m]: two steps of the LUX's distance resolution, 4 cm by its data sheet."""
    samples_per_point: int = 2
    """Line hypotheses per point, as in the code of Magri and Fusiello for local sampling."""
    locality: float = 0.25
    """Scale of the local sampling as a share of the segment's diagonal, as in their code."""
    points_max: int = 40
    """Larger segments are linked on an evenly spaced subset; every point is then assigned to the lines found."""
    length_min_m: float = 0.5
    """Minimum length of a further line [m]: a motorcycle is 0.7 wide, a mirror 0.25."""
    turn_min_deg: float = 20.0
    """Variant `lines`: minimum angle between a further line and each larger one [deg]."""
    range_std_m: float = 0.027
    """Variant `faces`: range noise along the beam [m]: a third of `tau_m`."""
    flatness_m: float = 0.01
    """Standard deviation of a vehicle's side from a plane [m]: it leans by 3 to 5 degrees above and below its widest
    line. A larger deviation of the points widens the gate, because real sides are curved."""
    gate: float = 3.0
    """Gate on the distance of a point to a face, in standard deviations."""
    curve_depth_m: float = 0.24
    """Depth behind a face within which points belong to it, but not to its direction [m]: fronts and rears of real
    cars are bowed by this much at hood height (median of 8), a rear window is at least 0.85 behind."""
    curve_beyond_m: float = 0.4
    """Distance past the ends of a face for the same [m]: corners of cars are rounded over 0.2 to 0.4."""
    pitch_deg: float = 0.25
    """Angle between beams, the accuracy of the end of a face [deg]."""
    seed: int = 0
    """Seed of the start of the hypotheses, which all segments share."""

    def __post_init__(self) -> None:
        if self.tau_m <= 0.0 or self.locality <= 0.0:
            raise ValueError("tau_m and locality must be positive")
        require_within(self, 1, 100, "samples_per_point")
        require_within(self, 2, 10_000, "points_max")
        if self.range_std_m < 0.0 or self.flatness_m <= 0.0 or self.gate <= 0.0:
            raise ValueError("flatness_m and gate must be positive and range_std_m not negative")
        if self.seed < 0:
            raise ValueError(f"seed is {self.seed}; give 0 or more")


@lru_cache(maxsize=8)
def uniforms(seed: int, points: int, samples: int) -> Floats:
    """(points, samples) numbers in [0, 1), the same for every segment, so that segments are independent.

    Stratified: the samples of a point are evenly spaced in its distribution, and shifted from point to point by the
    golden ratio (an additive recurrence, Kuipers and Niederreiter 1974), from a start that `seed` sets.
    """
    shift = (0.5 + GOLDEN * np.arange(points) + np.random.Generator(np.random.Philox(seed)).random()) % 1.0
    return np.asarray((shift[:, None] + np.arange(samples)) / samples)


def link(points_ego: npt.NDArray[np.floating], segments: Segments, config: LinkageConfig) -> Linkage:
    """Run algorithm 1 on every segment of points (N, 2 or more columns).

    The hypotheses are lines through pairs of near points. Clusters with overlapping preferences (1) are merged, nearest
    first by the Tanimoto distance (2), until all are orthogonal.

    `faces` takes the line of every cluster as a side of a rectangle, single or with a perpendicular side, and keeps the
    rectangle that explains most points: points on a side count for it, points outside or well inside against it. Its
    heading is fitted to both sides at once, with the noise of each point along its beam. Line 0 is the side with more
    information on the heading, 1 the other; points along unseen sides have higher numbers. `lines` accepts, after the
    largest cluster, each one that is long enough, turned against the larger ones, and has more unexplained points than
    expected by chance: fewer than one such line among as many scattered points (Desolneux, Moisan and Morel 2000). With
    `lines` and `paper` the line of the most points is the dominant one, fitted by total least squares. A third column
    of points is z [m], which identifies points of mirrors in the plane of a side.
    """
    order, offset = by_segment(segments)
    points = np.asarray(points_ego.take(order, axis=0)[:, :3], dtype=np.float64, order="C")
    chosen, first = even_subset(points, offset, config.points_max)
    sample, numbers = points[chosen], uniforms(config.seed, config.points_max, config.samples_per_point)
    cluster = link_samples(sample, first, numbers, config.locality, config.tau_m)
    if config.variant == "faces":
        label, heading = label_faces(points, offset, chosen, first, cluster, config)
    else:
        turn_min, paper = math.sin(math.radians(config.turn_min_deg)), config.variant == "paper"
        limits = config.tau_m, config.length_min_m, turn_min, paper
        label, heading = label_lines(points, offset, sample, first, cluster, *limits)
    line = np.full(len(segments.label), -1, dtype=np.int64)
    line[order] = label
    return Linkage(line=line, heading=fold(heading))
