"""T-linkage (algorithm 1): which points of a segment form lines, which none, and where the dominant line points."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import numpy.typing as npt

from tracker.arrays import Floats, Ints
from tracker.bounds import require_within
from tracker.detection.kernels.segments import FACES, LINES, PAPER, FaceLimits, LineLimits, link_segments
from tracker.detection.segmentation import by_segment
from tracker.geometry import fold
from tracker.records import Linkage, Segments

VARIANTS = {"faces": FACES, "lines": LINES, "paper": PAPER}


@dataclass(frozen=True, slots=True)
class LinkageConfig:
    """Scales of the linkage and what counts as a line."""

    variant: Literal["faces", "lines", "paper"] = "faces"
    """What becomes of T-linkage's clusters. `paper`: those before the largest jump in size are lines, all other points
    outliers. `lines`: those that chance would not make are lines, at any angle. `faces`: they propose the two
    perpendicular faces of a vehicle; what lies outside of these or well inside is an outlier."""
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
    """Of `lines`: a further line is turned at least so much against each larger one [deg]."""
    range_std_m: float = 0.026
    """Of `faces`: noise of ranges [m], along the beam: 2.5 cm of the LUX and what is left of its layers' biases."""
    flatness_m: float = 0.01
    """How flat a vehicle's side is [m]: it leans by 3 to 5 degrees above and below its widest line.
    What lies farther off by more than chance widens the gate: real sides bulge."""
    gate: float = 3.0
    """Standard deviations from a face within which a point is on it."""
    curve_depth_m: float = 0.2
    """What is no deeper behind a face belongs to it, though not to its direction [m]: bumpers, flanks and rounded
    corners curve that much, while a rear window lies 0.85 and more behind."""
    curve_beyond_m: float = 0.4
    """The same past the ends of a face [m]: corners of cars are rounded over 0.2 to 0.4."""
    pitch_deg: float = 0.25
    """Between beams [deg]: the end of a face is known no better."""
    seed: int = 0
    """Of the fixed table of random numbers that all segments share."""

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
    """(points, samples) numbers in [0, 1), the same for every segment: its result depends on its own points only."""
    return np.random.Generator(np.random.Philox(seed)).random((points, samples))


def link(points_ego: npt.NDArray[np.floating], segments: Segments, config: LinkageConfig) -> Linkage:
    """Run algorithm 1 on every segment of points (N, 2 or more columns).

    Lines through pairs of near points are the hypotheses; points whose preferences (1) overlap are merged, nearest
    first by the Tanimoto distance (2), until all clusters are orthogonal.

    `faces` takes every cluster's line for a side of a rectangle, alone or with another side across it, and keeps the
    rectangle that explains most points: on a side counts for it, outside or well inside against it. Its heading is
    fitted to both sides at once, with the noise of each point, which is along its beam. Line 0 is the side that says
    more about the heading, 1 the other; points along unseen sides have higher numbers. `lines` accepts, after the
    largest cluster, each one that is long enough, turned against the larger ones, and holds more of the points not yet
    explained than chance would give it: fewer than one such line expected among as many scattered points (Desolneux,
    Moisan and Morel 2000). With `lines` and `paper` the line of the most points is the dominant one, fitted by total
    least squares. A third column of points is z [m]: with it, points of mirrors in the plane of a side are told, too.
    """
    order, offset = by_segment(segments)
    label: Ints
    heading: Floats
    label, heading = link_segments(
        np.asarray(points_ego[order, :3], dtype=np.float64, order="C"),
        offset,
        uniforms(config.seed, config.points_max, config.samples_per_point),
        VARIANTS[config.variant],
        LineLimits(
            tau=config.tau_m,
            locality=config.locality,
            length_min=config.length_min_m,
            turn_min=math.sin(math.radians(config.turn_min_deg)),
        ),
        FaceLimits(
            noise=np.array([config.range_std_m, config.flatness_m]),
            gate=config.gate,
            depth_max=config.curve_depth_m,
            beyond_max=config.curve_beyond_m,
            pitch=math.radians(config.pitch_deg),
        ),
    )
    line = np.full(len(segments.label), -1, dtype=np.int64)
    line[order] = label
    return Linkage(line=line, heading=fold(heading))
