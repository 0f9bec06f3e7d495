"""All tracked vehicles as one table of arrays: every stage of tracking reads and changes its columns in place."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.kernels import inside
from luxloop.tracker.records import NO_MODEL, OrientedBoxes, Status
from luxloop.tracker.tracking.corner import rotated
from luxloop.tracker.tracking.vehicle_size import known, likely
from luxloop.tracker.vehicle_classes import CAR_LONGEST_M, CLASSES, GRID_M, WIDE_M

FACE_FRACTIONS = (0.2, 0.5, 0.8)
"""Places on each visible face, as fractions of its extent from the tracked corner."""


@dataclass(slots=True, eq=False)
class TrackTable:
    """T tracks, each followed by one corner of its vehicle, with M motion models; odometry frame, SI units, radians.

    A row is a track. Stages change rows in place; `subset` and `joined` make new tables.
    """

    models: tuple[str, ...]
    """Names of the M models."""
    id: Ints
    """(T,) never reused."""
    status: Ints
    """(T,) `Status`."""
    hits: Ints
    """(T,) observations."""
    unobserved_s: Floats
    """(T,) time since the last observation [s]; 0 for tracks that were updated in this frame."""
    age_s: Floats
    """(T,) time since the first observation [s]."""
    mean: Floats
    """(T, M, 6) states x, y, vx, vy, ax, ay of the tracked corner by each filter of the bank."""
    covariance: Floats
    """(T, M, 6, 6)."""
    probability: Floats
    """(T, M) model probabilities, equation (12)."""
    estimate: Floats
    """(T, 6) reported state, written by the model selection."""
    estimate_covariance: Floats
    """(T, 6, 6)."""
    independent_mean: Floats
    """(T, M, 6) states by filters without mixing, to compare the models."""
    independent_covariance: Floats
    """(T, M, 6, 6)."""
    nis: Floats
    """(T, M) normalised innovations squared of these, NaN without an observation in this frame."""
    corner_sign: Ints
    """(T, 2) signs of the tracked corner in the vehicle's frame."""
    corner_variance: Floats
    """(T, 2) time-correlated error of the corner, along and across the heading [m^2]."""
    first_offset_s: Floats
    """(T,) time of the first box minus time of its scan [s]."""
    yaw: Floats
    """(T, 2) heading and yaw rate."""
    yaw_covariance: Floats
    """(T, 2, 2)."""
    second_yaw: Floats
    """(T, 2) heading and yaw rate of the filter that may take over; NaN for none."""
    second_covariance: Floats
    """(T, 2, 2)."""
    second_s: Floats
    """(T,) age of that filter [s]."""
    rejected_headings: Ints
    """(T,) headings in a row that the paper's gate rejected."""
    oriented: Bools
    """(T,) mask of tracks whose direction of motion has confirmed the heading."""
    contradicted_from: Floats
    """(T, 2) tracked corner when the motion last agreed with the heading [m]."""
    axis_evidence: Floats
    """(T,) sum of the log-odds of the views that the length is along the heading."""
    axis_views: Ints
    """(T,) number of these views."""
    axis_log_odds: Floats
    """(T,) log-odds that the length is along the heading: a box turned by a quarter would cover another place."""
    size: Floats
    """(T, 2) length and width, unseen parts from priors [m]."""
    size_std: Floats
    """(T, 2) [m]."""
    size_likelihood: Floats
    """(T, 2, G) log-likelihoods of the sides of `GRID_M`, from independent views."""
    piece_likelihood: Floats
    """(T, 2, G) mean log-likelihoods of the truncated views: all of them together have the evidence of one."""
    size_views: Ints
    """(T, 2, 2) numbers of all views and of truncated ones, by side."""
    visible_size: Floats
    """(T, 2) seen length and width [m]."""
    whole_views: Ints
    """(T, 2) numbers of views of length and width from end to end."""
    prior_log_odds: Floats
    """(T,) log-odds of a vehicle before the views of its shape."""
    shape_evidence: Floats
    """(T, C) sums of the log-odds of the views for a vehicle of each class."""
    shape_views: Ints
    """(T,) number of these views."""
    left: Bools
    """(T,) mask of objects that were seen to move."""
    moved_before_hidden: Bools
    """(T,) mask of objects that were seen to move before they were hidden."""
    moved_views: Ints
    """(T,) successive views with evidence of motion."""
    first_places: Floats
    """(T, P, 2) places on the faces that the object occupied in its first view [m], NaN before and for others."""

    def __len__(self) -> int:
        return len(self.id)

    def subset(self, rows: Ints | Bools) -> "TrackTable":
        """Return a table of the tracks `rows`, copied."""
        return TrackTable(self.models, *[column[rows] for column in _columns(self)])

    def joined(self, others: Sequence["TrackTable"]) -> "TrackTable":
        """Return a table of these tracks and those of others after them."""
        if not others:
            return self
        parts = [_columns(table) for table in (self, *others)]
        return TrackTable(self.models, *[np.concatenate(column) for column in zip(*parts, strict=True)])

    @property
    def updated(self) -> Bools:
        """(T,) mask of tracks that were updated in this frame."""
        return np.asarray(self.unobserved_s == 0.0)

    @property
    def alive(self) -> Bools:
        """(T,) mask of tracks that are not terminated."""
        return np.asarray(self.status != DEAD)

    @property
    def confirmed_now(self) -> Bools:
        """(T,) mask of tracks that are confirmed and were updated in this frame."""
        return np.asarray((self.status == CONFIRMED) & self.updated)

    @property
    def model(self) -> Ints:
        """(T,) index of the selected model: the highest probability."""
        return np.asarray(self.probability.argmax(axis=1))

    @property
    def stationary(self) -> Bools:
        """(T,) mask of tracks with the stationary model selected."""
        index = self.models.index("stationary") if "stationary" in self.models else NO_MODEL
        return np.asarray(self.model == index)

    @property
    def heading(self) -> Floats:
        """(T,) [rad]."""
        return self.yaw[:, 0]

    @property
    def velocity(self) -> Floats:
        """(T, 2) velocity [m/s], zero if the stationary model is selected."""
        velocity = self.estimate[:, 2:4].copy()
        velocity[self.stationary] = 0.0
        return velocity

    @property
    def known_size(self) -> Floats:
        """(T, 2) part of length and width that is known to exist, from the tracked corner on [m]."""
        return known(self.visible_size, self.size)

    @property
    def likely_size(self) -> Floats:
        """(T, 2) part of length and width that probably exists, from the tracked corner on [m]."""
        return likely(self.visible_size, self.size, self.size_std)

    @property
    def corner_error(self) -> Floats:
        """(T, 2, 2) covariances of the time-correlated errors of the tracked corners [m^2]."""
        return np.asarray(rotated(self.corner_variance, self.heading.copy()))

    @property
    def corner_covariance(self) -> Floats:
        """(T, 2, 2) covariances of the tracked corners [m^2]."""
        return self.estimate_covariance[:, :2, :2] + self.corner_error

    @property
    def long(self) -> Bools:
        """(T,) mask of vehicles that are longer than a car."""
        return np.asarray(self.visible_size.max(axis=1, initial=0.0) > CAR_LONGEST_M)

    @property
    def shows_direction(self) -> Bools:
        """(T,) mask of vehicles whose direction is known: confirmed by motion, or by the length of a side."""
        return np.asarray((self.oriented | (self.visible_size[:, 0] > WIDE_M)) & (self.status == CONFIRMED))

    def boxes(self, size: Floats) -> OrientedBoxes:
        """Return the boxes of `size` (T, 2) [m] at the tracked corners."""
        heading = self.heading.copy()
        center = centers(self.estimate[:, :2].copy(), self.corner_sign, heading, size)
        return OrientedBoxes(center, heading, size, self.velocity, self.hits)

    def within(self, points: Floats) -> Bools:
        """(P, T) mask of points (P, 2) inside the likely parts of the vehicles."""
        boxes = self.boxes(self.likely_size)
        return inside(points, boxes.center, boxes.heading, boxes.size)


DEAD, CONFIRMED, COASTING, TENTATIVE = (
    int(status) for status in (Status.DEAD, Status.CONFIRMED, Status.COASTING, Status.TENTATIVE)
)
"""Values of `Status` for comparisons of arrays: numpy compares members of an enumeration ten times slower."""

_columns = attrgetter(*[field.name for field in fields(TrackTable)[1:]])
"""Arrays of a table, in the order of its fields."""


def empty(models: tuple[str, ...], rows: int = 0) -> TrackTable:
    """Return a table of `rows` blank tracks: zeros, and NaN where nothing is known."""
    m, g = len(models), len(GRID_M)
    shapes: dict[str, tuple[int, ...]] = {
        "mean": (m, 6), "covariance": (m, 6, 6), "probability": (m,), "estimate": (6,), "estimate_covariance": (6, 6),
        "independent_mean": (m, 6), "independent_covariance": (m, 6, 6), "nis": (m,), "corner_sign": (2,),
        "corner_variance": (2,), "yaw": (2,), "yaw_covariance": (2, 2), "second_yaw": (2,),
        "second_covariance": (2, 2), "contradicted_from": (2,), "size": (2,), "size_std": (2,),
        "size_likelihood": (2, g), "piece_likelihood": (2, g), "size_views": (2, 2), "visible_size": (2,),
        "whole_views": (2,), "shape_evidence": (len(CLASSES),), "first_places": (2 * len(FACE_FRACTIONS), 2),
    }  # fmt: skip
    columns: dict[str, Any] = {}
    for field in fields(TrackTable)[1:]:
        blank = np.nan if field.name in UNKNOWN else 0
        columns[field.name] = np.full((rows, *shapes.get(field.name, ())), blank, DTYPES[field.type])
    columns["axis_log_odds"][:] = -np.inf
    return TrackTable(models, **columns)


UNKNOWN = {"nis", "second_yaw", "first_places"}
"""Columns that are NaN at first."""

DTYPES: dict[Any, type] = {Floats: np.float64, Ints: np.int64, Bools: np.bool_}
"""Types of columns by their annotation."""


@kernel()
def centers(corner: Floats, sign: Ints, heading: Floats, size: Floats) -> Floats:
    """(B, 2) centres of boxes with corners (B, 2) of these signs (B, 2), headings (B,) and sizes (B, 2)."""
    center = np.empty((len(heading), 2))
    for b in range(len(heading)):
        cos, sin = elementary.cos(heading[b]), elementary.sin(heading[b])
        along, across = 0.5 * sign[b, 0] * size[b, 0], 0.5 * sign[b, 1] * size[b, 1]
        center[b, 0] = corner[b, 0] - (cos * along - sin * across)
        center[b, 1] = corner[b, 1] - (sin * along + cos * across)
    return center
