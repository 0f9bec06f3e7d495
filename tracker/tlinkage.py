"""T-linkage (algorithm 1): which points of a segment form lines, which none, and where the dominant line points."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from tracker.geometry import fold
from tracker.kernels.linkage import link_segments
from tracker.records import Floats, Ints, Linkage, Segments
from tracker.segmentation import by_segment


@dataclass(frozen=True, slots=True)
class LinkageConfig:
    """Scales of the linkage and what counts as a line."""

    tau_m: float = 0.08
    """Inlier threshold of equation (1) [m]. Three standard deviations of the LUX: 2.5 cm of range noise and 1.1 cm
    between its layers make 2.7 cm on a surface met face on."""
    samples_per_point: int = 2
    """Line hypotheses per point, the number of Magri and Fusiello's own code for local sampling."""
    locality: float = 0.25
    """Reach of the local sampling as a share of the segment's diagonal, theirs as well."""
    points_max: int = 40
    """Larger segments are linked on an even subset; every point is then given to the lines found."""
    length_min_m: float = 0.5
    """A further line is at least this long [m]: a motorcycle is 0.7 wide, a mirror 0.25."""
    turn_min_deg: float = 20.0
    """A further line is turned at least so much against each larger one [deg]: of two parallel lines on a convex body
    one lies within the outline, as a rear window behind the boot."""
    curve_depth_m: float = 0.2
    """Points so far behind a line as seen from the ego belong to it, though not to its direction [m]: bumpers, flanks
    and rounded corners curve that much, while a rear window lies 0.85 and more behind. 0 for none."""
    curve_beyond_m: float = 0.4
    """The same past the ends of a line [m]: corners of cars are rounded over 0.2 to 0.4."""
    seed: int = 0
    """Of the fixed table of random numbers that all segments share."""

    def __post_init__(self) -> None:
        if self.tau_m <= 0.0 or self.locality <= 0.0:
            raise ValueError("tau_m and locality must be positive")
        if self.samples_per_point < 1 or self.points_max < 2:
            raise ValueError("samples_per_point must be at least 1 and points_max at least 2")


@lru_cache(maxsize=8)
def uniforms(seed: int, points: int, samples: int) -> Floats:
    """(points, samples) numbers in [0, 1), the same for every segment: its result depends on its own points only."""
    return np.random.Generator(np.random.Philox(seed)).random((points, samples))


def link(points_ego: npt.NDArray[np.floating], segments: Segments, config: LinkageConfig) -> Linkage:
    """Run algorithm 1 on every segment of points (N, 2 or more columns).

    Lines through pairs of near points are the hypotheses; points whose preferences (1) overlap are merged, nearest
    first by the Tanimoto distance (2), until all clusters are orthogonal. The largest cluster is a line. A further
    one is, when it is long enough, turned against the larger ones, and holds more of the points not yet explained
    than chance would give it: fewer than one such line expected among as many scattered points (Desolneux, Moisan
    and Morel 2000). All others are outliers. Unlike a cut at the largest jump in size (Magri and Fusiello) this also
    judges one line alone, and a short side of few points. Lines are fitted once more, by total least squares, to the
    points nearest to them; the line with the most points is dominant, and each segment has one. Last, lines take up
    what curves away behind them.
    """
    order, offset = by_segment(segments)
    label: Ints
    heading: Floats
    label, heading = link_segments(
        np.asarray(points_ego[order, :2], dtype=np.float64, order="C"),
        offset,
        uniforms(config.seed, config.points_max, config.samples_per_point),
        config.tau_m,
        config.locality,
        config.length_min_m,
        math.sin(math.radians(config.turn_min_deg)),
        config.curve_depth_m,
        config.curve_beyond_m,
    )
    line = np.full(len(segments.label), -1, dtype=np.int64)
    line[order] = label
    return Linkage(line=line, heading=fold(heading))
