"""Hypotheses: every box as an observation of every track, with the ends of the vehicle that it shows."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop import elementary
from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.bounds import require_within
from luxloop.tracker.geometry import rotate
from luxloop.tracker.tracking.observations import Observations, uncut
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.vehicle_classes import FACE_MIN_M

COMPLETE_FRACTION = 0.85
"""A side is complete if this fraction of it is visible; rounded corners hide the rest."""


@dataclass(frozen=True, slots=True)
class HypothesisConfig:
    """Interpretation of a box as a view of a vehicle."""

    corner_margin_m: float = 0.5
    """Hysteresis of the tracked corner: another corner must be nearer to the ego by this much [m].
    Increase it if tracks change their corner too often."""
    end_std_m: float = 0.15
    """Standard deviation of an end whose face is not visible [m]: beam spacing, rounding,
    occlusion boundary. Increase it for a sensor with wider beam spacing."""

    def __post_init__(self) -> None:
        require_within(self, 0.0, 1e3, "corner_margin_m", "end_std_m")


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """Predicted states of T tracks by each of M models, in the odometry frame."""

    position: Floats
    """(T, M, 2) tracked corner at the scan's time [m]."""
    velocity: Floats
    """(T, M, 2) [m/s]."""
    covariance: Floats
    """(T, M, 2, 2) of the tracked corner."""
    probability: Floats
    """(T, M) model probabilities."""
    heading: Floats
    """(T,)."""
    heading_variance: Floats
    """(T,) [rad^2]."""
    size: Floats
    """(T, 2) length and width, unseen parts from priors [m]."""
    known_size: Floats
    """(T, 2) part of length and width that is known to exist, from the tracked corner on [m]."""
    whole: Bools
    """(T, 2) mask of length and width that were seen from end to end."""
    corner_sign: Ints
    """(T, 2) signs of the tracked corner."""

    @classmethod
    def of(cls, tracks: TrackTable) -> "Predictions":
        """Return those of the tracks of a table, after its prediction."""
        return cls(
            position=tracks.mean[:, :, :2].copy(),
            velocity=tracks.mean[:, :, 2:4].copy(),
            covariance=tracks.covariance[:, :, :2, :2] + tracks.corner_error[:, None],
            probability=tracks.probability,
            heading=tracks.heading.copy(),
            heading_variance=tracks.yaw_covariance[:, 0, 0].copy(),
            size=tracks.size,
            known_size=tracks.known_size,
            whole=tracks.whole_views > 0,
            corner_sign=tracks.corner_sign,
        )

    @property
    def to_corner(self) -> Floats:
        """(T, 2) vector from the box centre to the tracked corner [m]."""
        return rotate(0.5 * self.corner_sign * self.size, self.heading)

    @property
    def selected(self) -> Floats:
        """(T, 2) tracked corner by the likeliest model [m]."""
        return np.asarray(self.position[np.arange(len(self.heading)), self.probability.argmax(axis=1)])


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Every box as an observation of every track, (T, B) pairs, in the odometry frame."""

    heading: Floats
    """(T, B) heading of the box, turned by quarters to that of the track."""
    size: Floats
    """(T, B, 2) seen extent along and across that heading [m]."""
    untruncated: Bools
    """(T, B, 2) mask of axes, along and across that heading, on which the box is truncated at neither end."""
    innovation: Floats
    """(T, B, M, 2) measured minus predicted position of the tracked corner, by each model [m]."""
    covariance: Floats
    """(T, B, 2, 2) of the box's corner [m^2]."""
    ambiguity: Floats
    """(T, B, 2, 2) covariance to add where the box contains no information on the motion [m^2]."""
    corner_sign: Ints
    """(T, B, 2) signs of the corner to track from now on."""
    end_visible: Bools
    """(T, B, 2) mask of axes on which the near end of the box is the end of the vehicle."""
    innovation_lenient: Floats | None = None
    """(T, B, M, 2) as `innovation`, for a vehicle that extends over the whole of its assumed size: for the gate [m]."""


def hypothesise(tracks: Predictions, boxes: Observations, config: HypothesisConfig) -> Hypotheses:
    """Interpret each of B boxes as each of T tracks; the track's heading identifies length, width, front and rear.

    On axes with a visible end, the near end of the box is that of the vehicle. On other axes the box may be a piece of
    the side, truncated by an occluder or a gap between units: the innovation is only the part of the piece that
    protrudes from the known extent of the vehicle. Models are evaluated at the time of the box.

    `innovation_lenient` is the innovation under the smallest error of the size: the vehicle extends over the whole of
    its assumed size, and either end of a longer box may be that of the vehicle.

    The corner to track is the nearest one, with a hysteresis of `corner_margin_m`. Within the margin both corners are
    equally visible, and a change would cost accuracy. The track does not change to an end that is not visible now and
    was never visible, because the position of that end is unknown.
    """
    heading, size, near, cut = turned_views(tracks.heading, boxes.heading, boxes.size, boxes.corner_sign, boxes.cut)
    end_visible, corner_sign, innovation, innovation_lenient, faceless, ambiguity = interpret_pairs(
        (tracks.position, tracks.velocity, tracks.probability.argmax(axis=1)),
        tracks.heading,
        (tracks.size, tracks.known_size, tracks.corner_sign),
        (boxes.center, boxes.time_offset, boxes.sensor),
        (heading, size, near, cut),
        (config.corner_margin_m, config.end_std_m),
    )
    return Hypotheses(
        heading=heading,
        size=size,
        untruncated=uncut(cut),
        innovation=innovation,
        covariance=boxes.covariance[:, :2, :2] + faceless,
        ambiguity=ambiguity,
        corner_sign=corner_sign,
        end_visible=end_visible,
        innovation_lenient=innovation_lenient,
    )


def shows_end(size: Floats, near: Ints, cut: Bools, whole: Floats) -> Bools:
    """(2,) mask of axes on which the near end of a box of size (2,) with cut ends (4,) is the end of the vehicle.

    Its near signs are (2,), and the assumed sides of the vehicle (2,) [m].
    """
    view = size, near, cut, whole
    return np.array([end_is_visible(*view, axis) for axis in (0, 1)])


CAR_LENGTH_SPREAD_M = 1.5
"""Difference of the lengths of cars at most [m], but for few: the corner's error covers it."""

AMBIGUOUS_VARIANCE_M2 = 100.0
"""Variance of a measurement that neither corrects a filter nor separates models [m^2]."""

Pair = tuple[float, float]


@kernel()
def turned_views(
    track_heading: Floats, heading: Floats, size: Floats, sign: Ints, cut: Bools
) -> tuple[Floats, Floats, Ints, Bools]:
    """Return headings (T, B), sizes (T, B, 2), near signs (T, B, 2) and cut ends (T, B, 4) of boxes as T tracks.

    The heading of each of B boxes is turned by quarters to that of the track.
    """
    shape = len(track_heading), len(heading)
    own_heading, own_size = np.empty(shape), np.empty((*shape, 2))
    near, own_cut = np.empty((*shape, 2), np.int64), np.empty((*shape, 4), np.bool_)
    for t in range(shape[0]):
        for b in range(shape[1]):
            turns = round((track_heading[t] - heading[b]) / (0.5 * math.pi))
            own_heading[t, b] = heading[b] + turns * (0.5 * math.pi)
            x, y = sign[b]
            for _ in range(turns % 4):
                x, y = y, -x
            near[t, b, 0], near[t, b, 1] = x, y
            for axis in range(2):
                own_size[t, b, axis] = size[b, (axis + turns) % 2]
            for end in range(4):
                own_cut[t, b, end] = cut[b, (end + turns) % 4]
    return own_heading, own_size, near, own_cut


@kernel()
def end_is_visible(size: Floats, near: Ints, cut: Bools, whole: Floats, axis: int) -> bool:
    """Return True if the near end of a box on an axis is the end of the vehicle.

    It is if the face there is visible. Without a face, it is if the box is not truncated there, and its side is either
    about as long as the `whole` (2,) side [m], or truncated at the other end, which explains the difference.
    """
    if size[1 - axis] >= FACE_MIN_M:
        return True
    high, low = cut[axis], cut[axis + 2]
    near_cut, far_cut = (high, low) if near[axis] > 0 else (low, high)
    return not near_cut and (size[axis] >= COMPLETE_FRACTION * whole[axis] or far_cut)


@kernel()
def contradicts_size(offset: float, size: float, near: int, tracked: int, whole: float) -> bool:
    """Return True if a box contradicts an uncertain size on an axis: its far end is at the tracked end.

    The near end of such a box corrects the size of the vehicle. It is no end that moved. The centre of the box is at
    the `offset` from that of the vehicle, and the `whole` side is the assumed one [m].
    """
    growth = 0.5 * (size - whole)
    near_end, tracked_end = abs(offset + near * growth), abs(offset + tracked * growth)
    return near != tracked and near_end > CAR_LENGTH_SPREAD_M and tracked_end < near_end


@kernel()
def protrusion(offset: float, size: float, tracked: int, whole: float, extent: float) -> float:
    """Return the part of a box that protrudes from an extent of the vehicle, from its tracked corner on [m].

    The centre of the box is at the `offset` from that of the vehicle, whose side is assumed to be `whole` [m].
    """
    shift, excess = offset - 0.5 * tracked * (whole - extent), 0.5 * (size - extent)
    return max(shift + excess, 0.0) + min(shift - excess, 0.0)


@kernel()
def end_errors(offset: float, half_box: float, near: int, size: float, whole: float) -> Pair:
    """Return the distances [m] from the ends of the vehicle to those of the box: of the near ends, and the smaller one.

    `half_box` is the distance from the centre of the box to its near end, along the axis of the vehicle [m].
    """
    near_end = offset + (half_box - 0.5 * near * whole)
    far_end = near_end - near * max(size - whole, 0.0)
    return near_end, far_end if abs(far_end) < abs(near_end) else near_end


@kernel()
def set_covariance(matrix: Floats, heading: complex, along: float, across: float) -> None:
    """Write the covariance (2, 2) with variances along and across a heading, a unit vector."""
    x, y = heading.real, heading.imag
    matrix[0, 0], matrix[1, 1] = x * x * along + y * y * across, y * y * along + x * x * across
    matrix[0, 1] = matrix[1, 0] = x * y * (along - across)


@kernel()
def moves_corner(
    center: complex, heading: complex, tracked: Ints, near: Ints, size: Floats, sensor: complex, margin_m: float
) -> bool:
    """Return True if the near corner of a vehicle is nearer to the sensor than the tracked one, by a margin [m]."""
    of_tracked = center + heading * complex(0.5 * tracked[0] * size[0], 0.5 * tracked[1] * size[1]) - sensor
    of_near = center + heading * complex(0.5 * near[0] * size[0], 0.5 * near[1] * size[1]) - sensor
    return abs(of_tracked) > abs(of_near) + margin_m


@kernel()
def axis_errors(
    offset: float, half_box: float, axis: int, box: tuple[Floats, Ints, Bools], track: tuple[Floats, Floats, Ints]
) -> Pair:
    """Return the innovation and the lenient one on an axis [m]; see `set_innovations`."""
    (size, near, end_visible), (whole, known, tracked) = box, track
    if end_visible[axis]:
        return end_errors(offset, half_box, near[axis], size[axis], whole[axis])
    error = protrusion(offset, size[axis], tracked[axis], whole[axis], known[axis])
    return error, protrusion(offset, size[axis], tracked[axis], whole[axis], whole[axis])


@kernel()
def set_innovations(
    innovation: Floats,
    innovation_lenient: Floats,
    offset: complex,
    half: complex,
    heading: complex,
    box: tuple[Floats, Ints, Bools],
    track: tuple[Floats, Floats, Ints],
) -> tuple[bool, bool]:
    """Write the innovation (2,) and the lenient one (2,) of one model; return a flag for each axis.

    It is True on an axis on which a box without a visible end has no innovation.

    The box has a size, near signs and a mask of visible near ends, each (2,); its centre is at the `offset` from that
    of the vehicle, and its near corner is `half` a box away. The track has a size, a known size and tracked signs,
    each (2,).
    """
    end_visible = box[2]
    along, lenient_along = axis_errors(offset.real, half.real, 0, box, track)
    across, lenient_across = axis_errors(offset.imag, half.imag, 1, box, track)
    turned, turned_lenient = heading * complex(along, across), heading * complex(lenient_along, lenient_across)
    innovation[0], innovation[1] = turned.real, turned.imag
    innovation_lenient[0], innovation_lenient[1] = turned_lenient.real, turned_lenient.imag
    return not end_visible[0] and along == 0.0, not end_visible[1] and across == 0.0


@kernel()
def ends(
    center: complex,
    heading: complex,
    track: tuple[Floats, Floats, Ints],
    box: tuple[Floats, Ints, Bools, complex, complex],
    margin_m: float,
    end_visible: Bools,
    corner: Ints,
) -> None:
    """Write the mask (2,) of visible near ends of a box, and the signs (2,) of the corner to track.

    The track has a size, a known size and tracked signs, each (2,). The box has a size (2,), near signs (2,), cut ends
    (4,), a position, and that of the sensor. The track does not change to an end that is not visible now and was never
    visible.
    """
    (whole, known, tracked), (size, near, cut, position, sensor) = track, box
    from_center = (position - center) * heading.conjugate()
    moves = moves_corner(center, heading, tracked, near, whole, sensor, margin_m)
    for axis in range(2):
        offset = from_center.imag if axis else from_center.real
        uncertain = known[axis] < whole[axis] - margin_m
        end_visible[axis] = end_is_visible(size, near, cut, whole, axis)
        if uncertain and contradicts_size(offset, size[axis], near[axis], tracked[axis], whole[axis]):
            end_visible[axis] = False
        corner[axis] = near[axis] if moves and (end_visible[axis] or not uncertain) else tracked[axis]


@kernel()
def interpret_pairs(
    models: tuple[Floats, Floats, Ints],
    heading: Floats,
    tracks: tuple[Floats, Floats, Ints],
    boxes: tuple[Floats, Floats, Floats],
    views: tuple[Floats, Floats, Ints, Bools],
    settings: tuple[float, float],
) -> tuple[Bools, Ints, Floats, Floats, Floats, Floats]:
    """Return visible ends, next corners, innovations, lenient ones, faceless covariances and ambiguities of all pairs.

    Parameters
    ----------
    models
        Positions and velocities (T, M, 2) by each model, and the likeliest model (T,).
    heading
        (T,) of the tracks.
    tracks
        Sizes and known sizes (T, 2), and signs of tracked corners (T, 2).
    boxes
        Centres (B, 2), time offsets (B,), and positions of sensors (B, 2).
    views
        Result of `turned_views`.
    settings
        Fields of `HypothesisConfig`, in their order.
    """
    (position, velocity, best), (size, known, tracked) = models, tracks
    (box, time_offset, sensor), (box_heading, box_size, near, cut) = boxes, views
    shape, count = box_heading.shape, position.shape[1]
    end_visible, corner = np.empty((*shape, 2), np.bool_), np.empty((*shape, 2), np.int64)
    innovation, innovation_lenient = np.empty((*shape, count, 2)), np.empty((*shape, count, 2))
    faceless, ambiguity = np.empty((*shape, 2, 2)), np.empty((*shape, 2, 2))
    for t in range(shape[0]):
        along, track = elementary.rotation(heading[t]), (size[t], known[t], tracked[t])
        to_corner = along * complex(0.5 * tracked[t, 0] * size[t, 0], 0.5 * tracked[t, 1] * size[t, 1])
        center = complex(position[t, best[t], 0], position[t, best[t], 1]) - to_corner
        for b in range(shape[1]):
            place, own = complex(box[b, 0], box[b, 1]), box_size[t, b]
            view = own, near[t, b], cut[t, b], place, complex(sensor[b, 0], sensor[b, 1])
            ends(center, along, track, view, settings[0], end_visible[t, b], corner[t, b])
            half = 0.5 * complex(near[t, b, 0] * own[0], near[t, b, 1] * own[1])
            half *= elementary.rotation(box_heading[t, b] - heading[t])
            free_along, free_across, view_ends = True, True, (own, view[1], end_visible[t, b])
            for m in range(count):
                moved = complex(velocity[t, m, 0], velocity[t, m, 1]) * time_offset[b]
                offset = place - (complex(position[t, m, 0], position[t, m, 1]) - to_corner) - moved
                offset *= along.conjugate()
                free = set_innovations(
                    innovation[t, b, m], innovation_lenient[t, b, m], offset, half, along, view_ends, track
                )
                free_along, free_across = free_along and free[0], free_across and free[1]
            end_variance = settings[1] ** 2
            set_covariance(
                faceless[t, b], along, (own[1] < FACE_MIN_M) * end_variance, (own[0] < FACE_MIN_M) * end_variance
            )
            set_covariance(
                ambiguity[t, b], along, free_along * AMBIGUOUS_VARIANCE_M2, free_across * AMBIGUOUS_VARIANCE_M2
            )
    return end_visible, corner, innovation, innovation_lenient, faceless, ambiguity
