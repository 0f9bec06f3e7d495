"""Fit to one vehicle for a picture: points with their lines, and all rectangles in the frame of the true box."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.tracker.records import METHODS, Candidates

Floats = npt.NDArray[np.float64]


class Case(NamedTuple):
    """A fitted vehicle. Lengths in metres and angles in degrees, in the frame of the true box, x forward."""

    name: str
    points: Floats
    """(P, 2) of the segment."""
    line: npt.NDArray[np.int64]
    """(P,) line of each point, -1 for outliers."""
    size: tuple[float, float]
    """True length and width."""
    sensor: Floats
    """(2,) position of the ego or of the sensor."""
    errors: Floats
    """(M,) heading error of each of `METHODS`, -45 to 45; NaN without a rectangle."""
    center: Floats
    """(M, 2) centres of their rectangles."""
    extent: Floats
    """(M, 2) along and across their headings."""
    heading: Floats
    """(M,) headings [rad]."""
    best: int
    """The selected method."""

    @property
    def worst(self) -> float:
        """Absolute heading error of the selection."""
        return float(abs(self.errors[self.best]))

    @property
    def regret(self) -> float:
        """Error of the selection over the least error of a candidate."""
        return self.worst - float(np.nanmin(np.abs(self.errors)))


def case_of(
    name: str, points: Floats, line: npt.NDArray[np.int64], candidates: Candidates, segment: int, box: Floats
) -> Case:
    """Return the fit of a segment in the frame of its vehicle.

    Parameters
    ----------
    points, line
        (P, 2) points of the segment in the sensor's frame [m], and their lines.
    box
        (5,) true box in the same frame: x, y [m], heading [rad], length, width [m].
    """
    turn = np.array([[np.cos(box[2]), -np.sin(box[2])], [np.sin(box[2]), np.cos(box[2])]])
    methods = slice(0, len(METHODS))
    heading = candidates.heading[segment, methods] - box[2]
    return Case(
        name=name,
        points=(points - box[:2]) @ turn,
        line=line,
        size=(float(box[3]), float(box[4])),
        sensor=-box[:2] @ turn,
        errors=(np.rad2deg(heading) + 45.0) % 90.0 - 45.0,
        center=(candidates.center_ego[segment, methods] - box[:2]) @ turn,
        extent=candidates.size[segment, methods],
        heading=heading,
        best=int(candidates.best[segment]),
    )
