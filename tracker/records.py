"""Records that the stages of the tracker exchange.

Angles are in radians, counter-clockwise. N is the number of points, S of segments, B of boxes, T of tracks.

A box's heading points along one of its sides; its sides are `size` = (along heading, across heading).
A corner is identified by its signs in the box's frame: (+1, +1) is front left, (-1, +1) rear left, and so on.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints

METHODS = ("area", "closeness", "variance", "tlinkage", "refined")
"""Methods of candidate headings, in the order of the second axis of `Candidates`."""

BASELINES = ("principal_axes", "two_set_split", "ransac_lines", "jlinkage", "autoware")
"""Methods for comparison, never selected: the rest of that axis, see `luxloop.tracker.detection.baselines`."""

MODELS = ("stationary", "cv", "ca")
"""The standard filters of the bank, equations (7), (8) and (9); `Tracks.models` is the order of every model axis."""

TURNING_MODELS = ("ctrv", "ctra", "two-axle")
"""Models of turning vehicles: constant turn rate with constant velocity, the same with a constant change of speed, and
the kinematic single-track model, which moves along its heading and turns by its curvature."""

MODEL_NAMES = (*MODELS, *TURNING_MODELS)
"""All motion models that `[tracker.filters] models` may name."""

PREDICTION_S = (0.5, 1.0, 2.0)
"""Times ahead of `Tracks.prediction_odom` [s]."""

NOT_USED = -1
"""`Segments.label` of points in no segment."""

NO_TRACK = -1
"""`StepTrace.track_id` of boxes without a track."""

NO_MODEL = -1
"""`Tracks.model` of a tracker without motion models."""


class Status(IntEnum):
    """Status of a track."""

    TENTATIVE = 0
    CONFIRMED = 1
    COASTING = 2
    """Confirmed before and not observed now: kept for re-association."""
    DEAD = 3


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Groups of points that belong to one object each."""

    label: Ints
    """(N,) segment of each scan point, 0 to count - 1, or `NOT_USED`."""
    count: int
    """Number of segments S."""


@dataclass(frozen=True, slots=True, eq=False)
class SegmentedPoints:
    """Points of a scan in segments, sorted once by segment, and in the order of the scan within one.

    Every later stage takes slices: segment s has the rows offset[s] to offset[s + 1] of the P <= N points.
    """

    segments: Segments
    """Segment of each scan point."""
    offset: Ints
    """(S + 1,) first row of each segment, and P."""
    source: Ints
    """(P,) index of each point in the scan."""
    xy: Floats
    """(P, 2) ego frame [m]."""
    z: Floats
    """(P,) height above the ground [m]."""
    scan_line: Ints
    """(P,) number of the scan line, one per unit and layer, 0 and up."""
    time_offset: Floats
    """(P,) time of the point minus time of the scan [s]; 0 once the motion of its object is compensated."""
    viewpoint_ego: Floats
    """(P, 2) position of the unit that measured it [m]; the ego's centre if unknown."""
    truncated: Bools
    """(P,) mask of points at truncated ends."""

    @property
    def label(self) -> Ints:
        """(P,) segment of each point, ascending."""
        return self.segments.label.take(self.source)

    def chosen(self, mask: Bools) -> tuple[Floats, Ints]:
        """Return x and y (K, 2) of the points of a mask (P,), and the first one of each segment (S + 1,), and K."""
        return self.xy[mask], np.append(0, np.cumsum(mask))[self.offset]


@dataclass(frozen=True, slots=True, eq=False)
class Linkage:
    """Lines and outliers of T-linkage, algorithm 1."""

    line: Ints
    """(N,) line of its segment that a point belongs to, 0 for the dominant one, -1 for outliers and unused points.
    Numbers may be missing: 1 is the second visible face of a vehicle, 2 and up are points along unseen faces."""
    heading: Floats
    """(S,) direction of the dominant line, in [0, pi/2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Rectangles by segment and method: `METHODS`, then `BASELINES`, which are NaN if switched off."""

    heading: Floats
    """(S, M) in [0, pi/2), ego frame; the heading of a rectangle is modulo a quarter turn."""
    center_ego: Floats
    """(S, M, 2) [m]."""
    size: Floats
    """(S, M, 2) along and across heading [m]."""
    cost: Floats
    """(S, M) cost of the selection, in the unit of `selection.variant`; NaN for methods that it does not compare."""
    best: Ints
    """(S,) method of the lowest cost."""
    heading_variance: Floats | None = None
    """(S,) of the best rectangle [rad^2]; None if the selection gives none."""


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Selected rectangles of the B <= S segments of vehicle size."""

    segment: Ints
    """(B,) segment that the box was fitted to."""
    center_ego: Floats
    """(B, 2) [m]."""
    heading: Floats
    """(B,) in [0, pi/2), ego frame."""
    size: Floats
    """(B, 2) visible extent along and across heading [m]."""
    corner_ego: Floats
    """(B, 2) corner nearest to the ego [m]."""
    corner_sign: Ints
    """(B, 2) signs of that corner in the box's frame."""
    covariance: Floats
    """(B, 3, 3) of corner x, corner y [m] and heading [rad], ego frame."""
    support: Ints
    """(B,) points on the fitted lines."""
    time_offset: Floats
    """(B,) time of the box minus time of the scan [s]: mean over these points."""
    cut: Bools
    """(B, 2, 2) mask of truncated ends, low and high, along and across heading: the vehicle may extend beyond them."""
    flat: Bools
    """(B,) mask of boxes with a single side where a vehicle would show a second one, or that are a part of a larger
    object."""
    viewpoint_ego: Floats
    """(B, 2) mean position of the units that saw the box [m]."""

    def __len__(self) -> int:
        return len(self.segment)

    def subset(self, index: Ints | Bools) -> "Boxes":
        """Return the boxes of `index`."""
        return Boxes(
            self.segment[index],
            self.center_ego[index],
            self.heading[index],
            self.size[index],
            self.corner_ego[index],
            self.corner_sign[index],
            self.covariance[index],
            self.support[index],
            self.time_offset[index],
            self.cut[index],
            self.flat[index],
            self.viewpoint_ego[index],
        )


@dataclass(frozen=True, slots=True, eq=False)
class SmallBoxes:
    """Rectangles of the B <= S segments of the size of a person or a bicycle, odometry frame."""

    segment: Ints
    """(B,) segment that the box was fitted to."""
    center: Floats
    """(B, 2) [m]."""
    heading: Floats
    """(B,) modulo a quarter turn."""
    size: Floats
    """(B, 2) visible extent along and across heading [m]."""
    time_offset: Floats
    """(B,) mean time of its points minus time of the scan [s]."""

    def __len__(self) -> int:
        return len(self.segment)

    def subset(self, index: Ints | Bools) -> "SmallBoxes":
        """Return the boxes of `index`."""
        return SmallBoxes(
            self.segment[index], self.center[index], self.heading[index], self.size[index], self.time_offset[index]
        )


@dataclass(frozen=True, slots=True, eq=False)
class OrientedBoxes:
    """Boxes of T tracked vehicles, or of the visible parts of them, in the odometry frame."""

    center: Floats
    """(T, 2) [m]."""
    heading: Floats
    """(T,)."""
    size: Floats
    """(T, 2) length, width [m]."""
    velocity: Floats
    """(T, 2) [m/s]."""
    hits: Ints
    """(T,) observations."""

    def __len__(self) -> int:
        return len(self.heading)


STATE_COLUMNS: dict[str, slice | int] = {
    "center": slice(0, 2), "velocity": slice(2, 4), "acceleration": slice(4, 6), "heading": 6, "yaw_rate": 7,
}  # fmt: skip
"""Columns of `Tracks.mean`; "center" is that of the tracked corner."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """Output of the tracker: one row per reported track, in the odometry frame.

    State (6): x, y, vx, vy, ax, ay, heading, yaw rate, where x, y is the tracked corner.
    `from_boxes` makes the record of a tracker without motion models.
    """

    id: Ints
    """(T,) never reused."""
    status: npt.NDArray[np.uint8]
    """(T,) `Status`."""
    mean: Floats
    """(T, 8) state of the selected model [m, s, rad]; heading modulo a full turn. Velocity, acceleration and yaw rate
    are NaN if the tracker does not estimate them."""
    covariance: Floats
    """(T, 8, 8); NaN if the tracker does not estimate it."""
    model_probability: Floats
    """(T, M) equation (12), rows sum to 1; M is the length of `models`. NaN without models."""
    model: Ints
    """(T,) index of the selected model in `models`; `NO_MODEL` without models."""
    model_position_odom: Floats
    """(T, M, 2) tracked corner by each independent model [m]; NaN without models."""
    corner_sign: Ints
    """(T, 2) signs of the tracked corner in the vehicle's frame (x forward, y left); (0, 0) for the box centre."""
    size: Floats
    """(T, 2) length, width [m]."""
    model_covariance_odom: Floats | None = None
    """(T, M, 2, 2) covariance of that corner [m^2]; None if the tracker does not report it."""
    model_nis: Floats | None = None
    """(T, M) normalised innovation squared of each model's corner in this frame, 2 degrees of freedom; NaN
    for tracks that were not updated, None if the tracker does not report it."""
    prediction_odom: Floats | None = None
    """(T, M + 1, len(PREDICTION_S), 2) tracked corner ahead of the scan's time, by each independent model and by the
    reported estimate [m]; None if the tracker does not report it."""
    small: Bools | None = None
    """(T,) mask of tracks of small road users, people and bicycles; the others are vehicles. None if the tracker does
    not tell them apart."""
    models: tuple[str, ...] = MODELS
    """Names of the M models, of `MODEL_NAMES`: the order of every per-model axis."""

    def __len__(self) -> int:
        return len(self.id)

    @classmethod
    def from_boxes(
        cls,
        id: npt.ArrayLike,
        center: npt.ArrayLike,
        heading: npt.ArrayLike,
        size: npt.ArrayLike,
        velocity: npt.ArrayLike | None = None,
        acceleration: npt.ArrayLike | None = None,
        yaw_rate: npt.ArrayLike | None = None,
        status: npt.ArrayLike = Status.CONFIRMED,
        small: npt.ArrayLike | None = None,
    ) -> "Tracks":
        """Make the record of a tracker without motion models; what is left out is not graded.

        Parameters
        ----------
        id
            (T,) integers from 0.
        center
            (T, 2) box centres in the odometry frame [m].
        heading
            (T,) heading of the front [rad], or one value for all.
        size
            (T, 2) length, width [m], or one pair for all.
        velocity, acceleration
            (T, 2) of the box centre over ground, on the axes of the odometry frame [m/s, m/s^2]; NaN where unknown.
        yaw_rate
            (T,) [rad/s]; NaN where unknown.
        status
            (T,) `Status`, or one value for all.
        small
            (T,) True for people and bicycles, or one value for all; None if the tracker does not tell them from
            vehicles.

        Raises
        ------
        ValueError
            A field does not have the shape of T tracks, or an id is not an integer.
        """
        ids = np.atleast_1d(np.asarray(id))
        if ids.size and ids.dtype.kind not in "iu":
            raise ValueError(f"id holds {ids.dtype}; give one integer per track")
        count = len(ids)
        mean = np.full((count, 8), np.nan)
        given = {"center": center, "velocity": velocity, "acceleration": acceleration, "heading": heading,
                 "yaw_rate": yaw_rate}  # fmt: skip
        for name, values in given.items():
            if values is not None:
                columns = STATE_COLUMNS[name]
                mean[:, columns] = _per_track(name, values, mean[:, columns].shape)
        sizes = _per_track("size", size, (count, 2)).copy()
        return cls(
            id=ids.astype(np.int64),
            status=_per_track("status", status, (count,)).astype(np.uint8),
            mean=mean,
            covariance=np.full((count, 8, 8), np.nan),
            model_probability=np.full((count, len(MODELS)), np.nan),
            model=np.full(count, NO_MODEL),
            model_position_odom=np.full((count, len(MODELS), 2), np.nan),
            corner_sign=np.zeros((count, 2), np.int64),
            size=sizes,
            small=None if small is None else _per_track("small", small, (count,)).astype(np.bool_),
        )

    @property
    def center_odom(self) -> Floats:
        """(T, 2) box centre [m]."""
        from luxloop.tracker.geometry import rotate  # imports numba, which readers of names do not need

        return self.mean[:, :2] - rotate(0.5 * self.corner_sign * self.size, self.mean[:, 6])


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """Results of the detection stages for one scan."""

    segments: Segments
    linkage: Linkage
    candidates: Candidates
    boxes: Boxes


@dataclass(frozen=True, slots=True, eq=False)
class StepTrace(Detection):
    """Intermediate results of one step, for the grader, the recorder and tests."""

    track_id: Ints
    """(B,) id of the track that each box updated or started, `NO_TRACK` for none."""


def _per_track(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Floats:
    """Return numbers in a shape of one row per track; a single row applies to all tracks."""
    given = np.asarray(values, dtype=np.float64)
    if given.size == 0 and shape[0] == 0:
        return np.empty(shape)
    if given.shape not in (shape, shape[1:]):
        raise ValueError(f"{name} has shape {given.shape}; give {shape}, one row for each of the {shape[0]} tracks")
    return np.broadcast_to(given, shape)
