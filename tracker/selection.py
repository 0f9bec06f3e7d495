"""Best selection: the candidate along whose sides the points on lines lie closest, equation (3)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from tracker.kernels.selection import side_distances
from tracker.records import Candidates, Linkage, Segments
from tracker.rectangles import Rectangles


@dataclass(frozen=True, slots=True)
class SelectionConfig:
    """Which cost decides."""

    variant: Literal["faces", "paper"] = "faces"
    """`paper`: equation (3), the variance of the absolute residuals on the dominant line. T-linkage's heading is its
    least-squares direction, so that others hardly win. `faces`: the squared mean of the absolute residuals on all
    lines, each residual capped. It too measures their spread, but rounded corners weigh less, and a short dominant
    side is outvoted by a long one: for Laplacian noise it is the likelihood of the heading given the lines."""
    residual_max_m: float = 0.08
    """Cap of `faces` [m], three standard deviations of the points: beyond, a point is not on a side's flat part."""

    def __post_init__(self) -> None:
        if self.residual_max_m <= 0.0:
            raise ValueError(f"residual_max_m is {self.residual_max_m}; give a positive distance in metres")


def select(
    points_ego: npt.NDArray[np.floating],
    segments: Segments,
    linkage: Linkage,
    rectangles: Rectangles,
    config: SelectionConfig,
) -> Candidates:
    """Cost of every rectangle for points (N, 2 or more columns), and the cheapest per segment.

    A residual is a point's distance to the side of the rectangle that its line lies along, moved to the middle of
    the line. (3) leaves the offset c of H open; at the edge of a tight rectangle all residuals would have one sign,
    the absolute value would do nothing, and least squares would win always.
    """
    judged = np.flatnonzero(linkage.line == 0 if config.variant == "paper" else linkage.line >= 0)
    judged = judged[np.lexsort((linkage.line[judged], segments.label[judged]))]
    segment, line = segments.label[judged], linkage.line[judged]
    start = np.flatnonzero(np.diff(segment, prepend=-1) | np.diff(line, prepend=-1))
    distance = side_distances(
        np.asarray(points_ego[judged, :2], dtype=np.float64, order="C"),
        np.append(start, len(judged)),
        rectangles.heading[segment[start]],
    )
    if config.variant == "faces":
        distance = np.minimum(distance, config.residual_max_m)
    first = np.searchsorted(segment, np.arange(segments.count))
    count = np.diff(first, append=len(judged))[:, None]
    cost = (np.add.reduceat(distance, first) / count) ** 2
    if config.variant == "paper":
        cost = np.add.reduceat(distance**2, first) / count - cost
    return Candidates(
        heading=rectangles.heading,
        center_ego=rectangles.center_ego,
        size=rectangles.size,
        cost=cost,
        best=np.argmin(cost, axis=1),
    )
