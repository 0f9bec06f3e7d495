"""Records between the tracker's stages. Angles are radians, counter-clockwise; N points, S segments, T tracks.

A box's heading points along one of its sides; its sides are `size` = (along heading, across heading).
A corner is named by its signs in the box's frame: (+1, +1) is front left, (-1, +1) rear left, and so on.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from tracker.arrays import Bools, Floats, Ints
from tracker.geometry import rotate

METHODS = ("area", "closeness", "variance", "tlinkage", "refined")
"""Where a candidate heading comes from, in the order of `Candidates`' second axis."""

BASELINES = ("principal_axes", "two_set_split", "ransac_lines", "jlinkage", "autoware")
"""Methods that are measured for comparison and never selected: the rest of that axis, see `tracker.baselines`."""

MODELS = ("stationary", "cv", "ca")
"""The filters of the bank, equations (7), (8) and (9), in the order of every per-model axis."""

NOT_USED = -1
"""`Segments.label` of points in no segment."""

NO_TRACK = -1
"""`StepTrace.track_id` of boxes without a track."""


class Status(IntEnum):
    """Life of a track."""

    TENTATIVE = 0
    CONFIRMED = 1
    COASTING = 2
    """Confirmed before, not seen now: kept for re-association."""
    DEAD = 3


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Points grouped into things."""

    label: Ints
    """(N,) segment of each scan point, 0 to count - 1, or `NOT_USED`."""
    count: int


@dataclass(frozen=True, slots=True, eq=False)
class Linkage:
    """T-linkage's verdict on the points, algorithm 1."""

    line: Ints
    """(N,) which line of its segment a point belongs to, 0 the dominant one; -1 for outliers and unused points. Numbers
    may be missing: of a vehicle's faces 1 is the other seen one, from 2 on are points along unseen ones."""
    heading: Floats
    """(S,) direction of the dominant line, in [0, pi/2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """One rectangle per segment and method: `METHODS`, and after them `BASELINES`, NaN where these are switched off."""

    heading: Floats
    """(S, M) in [0, pi/2), ego frame; a rectangle's heading is known modulo a quarter turn."""
    center_ego: Floats
    """(S, M, 2) [m]."""
    size: Floats
    """(S, M, 2) along and across heading [m]."""
    cost: Floats
    """(S, M) what the selection compares, in the unit of `selection.variant`; NaN for baselines."""
    best: Ints
    """(S,) method of the lowest cost."""


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """The selected rectangle of each segment that looks like a vehicle (B <= S of them)."""

    segment: Ints
    """(B,) the segment it was fitted to."""
    center_ego: Floats
    """(B, 2) [m]."""
    heading: Floats
    """(B,) in [0, pi/2), ego frame."""
    size: Floats
    """(B, 2) seen extent along and across heading [m]."""
    corner_ego: Floats
    """(B, 2) the corner nearest to the ego [m]."""
    corner_sign: Ints
    """(B, 2) which corner that is, signs in the box's frame."""
    covariance: Floats
    """(B, 3, 3) of corner x, corner y [m] and heading [rad], ego frame."""
    support: Ints
    """(B,) points on the fitted lines."""
    time_offset: Floats
    """(B,) when it was where it is, after the scan's time [s]: mean over these points."""
    cut: Bools
    """(B, 2, 2) whether it may go on, unseen, beyond its low and its high end along and across heading."""
    flat: Bools
    """(B,) whether it has one side only, where a second one would be in plain view were it a vehicle, or is but a part
    of something larger."""

    def __len__(self) -> int:
        return len(self.segment)

    def subset(self, index: Ints | Bools) -> "Boxes":
        """Only the boxes of `index`."""
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
        )


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """What the tracker reports: one row per living track, in the odometry frame.

    State (6): x, y, vx, vy, ax, ay, heading, yaw rate, where x, y is the tracked corner.
    """

    id: Ints
    """(T,) never reused."""
    status: npt.NDArray[np.uint8]
    """(T,) `Status`."""
    mean: Floats
    """(T, 8) state of the selected model [m, s, rad]; heading modulo a full turn."""
    covariance: Floats
    """(T, 8, 8)."""
    model_probability: Floats
    """(T, len(MODELS)) equation (12), rows sum to 1."""
    model: Ints
    """(T,) the selected model."""
    model_position_odom: Floats
    """(T, len(MODELS), 2) the tracked corner by each model alone [m]."""
    corner_sign: Ints
    """(T, 2) which corner of the vehicle is tracked, signs in the vehicle's frame (x forward, y left)."""
    size: Floats
    """(T, 2) length, width [m]."""
    model_covariance_odom: Floats | None = None
    """(T, len(MODELS), 2, 2) of that corner by each model alone [m^2]; None from a tracker that does not tell."""
    model_nis: Floats | None = None
    """(T, len(MODELS)) normalised innovation squared of each model's corner in this frame, 2 degrees of freedom; NaN
    where it was not updated, None from a tracker that does not tell."""

    def __len__(self) -> int:
        return len(self.id)

    @property
    def center_odom(self) -> Floats:
        """(T, 2) box centre: half the box away from the tracked corner [m]."""
        return self.mean[:, :2] - rotate(0.5 * self.corner_sign * self.size, self.mean[:, 6])


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """All that the fitting half made of a scan."""

    segments: Segments
    linkage: Linkage
    candidates: Candidates
    boxes: Boxes


@dataclass(frozen=True, slots=True, eq=False)
class StepTrace(Detection):
    """Everything between scan and tracks, for the grader, the recorder and tests."""

    track_id: Ints
    """(B,) the track each box was given to or started."""
