"""Errors of fitted rectangles: heading, nearest corner, visible extents and overlap.

`bound` is the lower bound of the heading error of an observation, from its true points on faces of unknown position and
bow.

A beam leaves its unit at o in a known direction u and meets a face, whose outward normal is n(h) at heading h. The face
is bowed: with q = (t / T)^2 at the position t along it, from its middle, and the sagitta s over +-T, it is the curve
n(h) . x = d - s q. The range is measured with a normal error of variance s_r^2, so that, about a flat face,

    r = (d - s q - n . o) / (n . u) + noise,    dr/dd = 1 / (n . u),    dr/ds = -q / (n . u),    dr/dh = -t / (n . u).

The weight of each range is w = 1 / (s_r n . u)^2, because the error of the point across its face is the range noise
projected on the normal. The heading is common to all faces of a vehicle. Each face has its own offset d, because the
size of the vehicle is unknown, and its own sagitta s, of which only the distribution over real cars is known, with
variance v. With t and q measured from their weighted means on the face, the information of h after elimination of d
and s is

    I(h) = sum over faces of  (sum w t^2)  -  (sum w t q)^2 / (sum w q^2 + 1 / v).

No estimator that is unbiased in h for every d, on average over s, has a standard deviation below I(h)^-1/2. This is the
hybrid bound (Rockah and Schultheiss 1987, Array shape calibration, IEEE Trans. ASSP 35(3)) of constant h and d and a
random s. The elimination is that of Kay 1993 (Fundamentals of Statistical Signal Processing I, section 3.7), whose
example 3.7 is one flat face with equal weights.

The points are all those on the body in the segment, as in a fit. Points on rounded corners count for the face that the
beam meets most directly, and so do points deeper than the outline (glass, hood). All choices favour a small bound: the
depth of every layer behind its face is known, the middle of each face is known, a parabola is its exact shape, and
range noise is the only error.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading import body_points
from luxloop.scenarios.grading.body_points import BodyPoints, Complexes, Ranging
from luxloop.scenarios.grading.frame_tables import columns_of, rows_of_pairs
from luxloop.scenarios.grading.frame_truth import NO_ACTOR_ROW, FrameTruth, Ownership
from luxloop.scenarios.grading.plane_geometry import (
    QUARTER,
    corner,
    iou,
    matching_sign,
    nearest_sign,
    turned,
    wrap,
)
from luxloop.sensor_model.truth import Cause
from luxloop.sensor_model.visibility import MAX_CLEAN_DEPTH
from luxloop.sim.world import Kind
from luxloop.tracker.records import METHODS, Boxes, StepTrace

CORNER_RADIUS_M = np.array(
    [{Kind.CAR: 0.25, Kind.SUV: 0.25, Kind.VAN: 0.27}.get(kind, 0.15) for kind in Kind], dtype=np.float64
)
"""Largest corner radius of a body by `Kind` [m]. A bevel of width w replaces an arc of radius w / (2 tan(22.5 deg))."""

BOW_STD_M = np.array([0.12, 0.03, 0.12, 0.03])
"""Spread of the sagitta of real cars by face: quartile distance over 1.35 [m], see docs/realism.md."""
BOW_SHARE = np.array([0.83, 0.7, 0.83, 0.7])
"""Share of the face over which that sagitta was measured: 1.5 m of an end of 1.8 m, 3.2 m of a flank of 4.6 m."""

NORMALS = np.array([1.0, 1.0j, -1.0, -1.0j])
"""Outward normals of the faces 0 to 3: front, left, rear and right."""

UNIFORM_STD = 0.5 * np.pi / np.sqrt(12.0)
"""Standard deviation of a uniformly random heading modulo 90 degrees [rad]. A larger bound has no meaning."""


def observed(frame_truth: FrameTruth, ranging: Ranging, points: BodyPoints, owner: Ints) -> Floats:
    """(K,) bounds of the headings of one frame's fit observations [rad].

    NaN for vehicles whose points contain no information about the heading, for trucks that are bent at all (their faces
    have two headings), and for all with exact ranges.

    Parameters
    ----------
    points
        Points on the observed vehicles.
    owner
        (K,) rows of the observed actors.
    """
    if not ranging.sigma.any() or not len(owner):
        return np.full(len(owner), np.nan)
    actors, scan = frame_truth.actors, frame_truth.scan
    deep = frame_truth.truth.cause[points.point] == Cause.LAYER_OVERLAP
    face, along = on_faces(
        points.position, points.beam, actors.size[points.row], CORNER_RADIUS_M[actors.kind[points.row]], deep
    )
    sigma = ranging.sigma[scan.unit[points.point]] * np.asarray(-(points.beam * NORMALS[face].conj()).real)
    bent = np.asarray(actors.joint_angles.any(axis=1))
    kept = (sigma > 0.0) & ~bent[points.row]  # a beam meets no face from behind
    place = along / (0.5 * BOW_SHARE[face] * actors.size[points.row, 1 - face % 2])
    return bound(points.observation[kept], face[kept], along[kept], place[kept], sigma[kept], len(owner))


def on_faces(
    points_body: Complexes, beam_body: Complexes, size: Floats, corner_radius: Floats, deep: Bools
) -> tuple[Ints, Floats]:
    """Return the face (P,) of each point and its position along the face, from the middle (P,) [m].

    Faces are 0 to 3: front, left, rear and right. Points on rounded corners and off the outline are on the face that
    their beam meets most directly.

    Parameters
    ----------
    points_body, beam_body
        (P,) points and unit vectors of their beams, x + iy in the frame of their vehicle [m].
    size, corner_radius
        (P, 2) or more, length and width first, and (P,), of the point's vehicle [m].
    deep
        (P,) mask of points that are off the outline.
    """
    x, y = points_body.real, points_body.imag
    from_end, from_side = 0.5 * size[:, 0] - np.abs(x), 0.5 * size[:, 1] - np.abs(y)
    at_end = (np.abs(from_end) <= MAX_CLEAN_DEPTH) & (from_side >= corner_radius) & ~deep
    at_side = (np.abs(from_side) <= MAX_CLEAN_DEPTH) & (from_end >= corner_radius) & ~deep
    end, side = np.where(x > 0.0, 0, 2), np.where(y > 0.0, 1, 3)
    directly = np.argmax(-(beam_body[:, None] * NORMALS.conj()).real, axis=1)
    face = np.where(at_end, end, np.where(at_side, side, directly))
    return face, np.where(face % 2, x, y)


def bound(observation: Ints, face: Ints, along: Floats, place: Floats, sigma: Floats, count: int) -> Floats:
    """(count,) bounds of the headings of observations [rad]; NaN without information about the heading.

    Parameters
    ----------
    observation, face
        (P,) observation of each point, and its face, 0 to 3.
    along
        (P,) position along the face, from its middle [m].
    place
        (P,) the same over T, half the width of the bow.
    sigma
        (P,) standard deviation of the point across its face [m].
    """
    group, groups = observation * len(NORMALS) + face, count * len(NORMALS)
    weight = sigma**-2.0
    total = np.maximum(np.bincount(group, weight, groups), 1e-300)  # of faces without points: no division by zero

    def from_mean(values: Floats) -> Floats:
        return np.asarray(values - (np.bincount(group, weight * values, groups) / total)[group])

    t, q = from_mean(along), from_mean(place**2)
    tt, tq, qq = (np.bincount(group, weight * product, groups) for product in (t * t, t * q, q * q))
    bow = np.tile(BOW_STD_M**-2.0, count)
    information = (tt - tq**2 / (qq + bow)).reshape(count, -1).sum(axis=1)
    bounded = information > UNIFORM_STD**-2.0
    return np.where(bounded, np.where(bounded, information, 1.0) ** -0.5, np.nan)


BOX = ("x_ego_m", "y_ego_m", "heading_ego_rad", "length_m", "width_m")
"""Columns of a rectangle."""
TRUE_BOX = ("true_x_ego_m", "true_y_ego_m", "true_yaw_ego_rad", "true_length_m", "true_width_m")
"""Columns of the true box."""
SEEN = ("seen_length_m", "seen_width_m")
"""Columns of the visible extents."""


def measure(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle, and mark the least heading error of each observation as `oracle`."""
    found = errors(fits)
    return found.assign(oracle=_oracle(fits["method"].cat.codes.to_numpy(), found["heading_error_deg"].to_numpy()))


def errors(fits: pd.DataFrame) -> pd.DataFrame:
    """Add the errors of every rectangle.

    Heading errors are modulo 90 degrees, in (-45, 45]. The position error is the distance from the rectangle's corner
    nearest to the ego to the same corner of the true box. The rectangle chooses the corner: for a vehicle abreast, with
    two equally near corners, independent choices could differ by the whole length. Its components are along and across
    the vehicle, positive outwards: the corner is beyond that of the true box. Errors of the extents, along and across,
    are the rectangle's extents minus those of the vehicle's true points.
    """
    box, true = columns_of(fits, BOX), columns_of(fits, TRUE_BOX)
    turn = box[:, 2] - true[:, 2]
    error = heading_errors(box, true)
    turn = np.where(np.isfinite(error), turn, 0.0)
    gap, true_sign = corner_gaps(box, true, turn)
    outwards = true_sign * turned(gap, -true[:, 2])
    sideways = np.round(turn / QUARTER) % 2 == 1
    size = np.where(sideways[:, None], box[:, :2:-1], box[:, 3:])
    extent = size - columns_of(fits, SEEN)
    return fits.assign(
        heading_error_deg=error,
        box_heading_error_deg=np.degrees(wrap(fits["box_heading_ego_rad"].to_numpy() - true[:, 2], QUARTER)),
        position_error_m=np.hypot(gap[:, 0], gap[:, 1]),
        corner_along_error_m=outwards[:, 0],
        corner_across_error_m=outwards[:, 1],
        extent_along_error_m=extent[:, 0],
        extent_across_error_m=extent[:, 1],
        iou=iou(box, true),
    )


def heading_errors(box: Floats, true: Floats) -> Floats:
    """(N,) heading errors of rectangles (N, 5) modulo 90 degrees, in (-45, 45] [deg]."""
    error: Floats = np.degrees(wrap(box[:, 2] - true[:, 2], QUARTER))
    return error


def corner_gaps(box: Floats, true: Floats, turn: Floats) -> tuple[Floats, Ints]:
    """Return (N, 2) gaps from the true corner to the rectangle's nearest one, and (N, 2) signs of the true corner.

    Parameters
    ----------
    box, true
        (N, 5) rectangles and true boxes, about the ego.
    turn
        (N,) heading of the rectangle minus that of the true box [rad].
    """
    sign = nearest_sign(box)
    true_sign = matching_sign(sign, turn)
    return corner(box, sign) - corner(true, true_sign), true_sign


def _oracle(method: np.ndarray[tuple[int], np.dtype[np.int8]], error: Floats) -> Bools:
    """Mark the least error among each observation's `METHODS`; baselines are not selectable, NaN is skipped."""
    choice = np.flatnonzero(method < len(METHODS)).reshape(-1, len(METHODS))
    least = choice[np.arange(len(choice)), np.where(np.isfinite(error), np.abs(error), np.inf)[choice].argmin(axis=1)]
    oracle = np.zeros(len(error), dtype=np.bool_)
    oracle[least] = np.isfinite(error[least])
    return oracle


def with_regret(fitted: pd.DataFrame) -> pd.DataFrame:
    """Add `regret_deg`: the gain of a perfect selection among `METHODS`, NaN except for selected rectangles.

    The regret overstates the fault of the selection, because the least of several errors is partly small by chance.
    """
    frame, actor = fitted["frame"].to_numpy(), fitted["actor_id"].to_numpy()
    error = np.abs(fitted["heading_error_deg"].to_numpy(np.float64))
    oracle = np.flatnonzero(fitted["oracle"])
    row = rows_of_pairs(frame, actor, frame[oracle], actor[oracle])
    least = np.append(error[oracle], np.nan)[row]
    return fitted.assign(regret_deg=np.where(fitted["best"], error - least, np.nan))


def fit_rows(
    frame_truth: FrameTruth, ownership: Ownership, trace: StepTrace, ranging: Ranging | None
) -> dict[str, npt.NDArray[Any]]:
    """Return the fit observations of one frame: a row per candidate of each graded vehicle with a segment."""
    owner, segment = _largest_segments(ownership)
    fitted = trace.candidates
    methods = fitted.heading.shape[1]  # fitting the baselines, the last of `CANDIDATES`, is optional
    box = np.dstack([fitted.center_ego[segment], fitted.heading[segment], fitted.size[segment]]).reshape(-1, len(BOX))
    method = np.tile(np.arange(methods), len(segment))

    def each(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return np.repeat(values, methods, axis=0)

    observations = {
        "segment": segment,
        "actor_id": frame_truth.actors.id[owner],
        "view": frame_truth.truth.view[owner],
        "range_m": frame_truth.range_m[owner],
        "points": ownership.size[segment],
        **_of_points(frame_truth, ranging, trace.segments.label, owner, segment),
        **_of_boxes(trace.boxes, segment),
        **dict(zip(TRUE_BOX, frame_truth.boxes_ego[owner].T, strict=True)),
    }
    columns = {
        **{name: each(values) for name, values in observations.items()},
        "method": method,
        "cost": fitted.cost[segment].ravel(),
        "best": method == each(fitted.best[segment]),
        **dict(zip(BOX, box.T, strict=True)),
    }
    kept = (method < len(METHODS)) | np.isfinite(box[:, 2])  # disabled baselines have no rows
    return {name: values[kept] for name, values in columns.items()}


def _largest_segments(ownership: Ownership) -> tuple[Ints, Ints]:
    """Return the owners (K,) and the segment (K,) with most points of each.

    As in the paper, a vehicle is observed once per frame. Its other segments are fragments, like a wheel seen under
    another car or the end of a bumper. They carry no heading information and count as over-segmentation.
    """
    segment = np.flatnonzero(ownership.owner != NO_ACTOR_ROW)
    owner = ownership.owner[segment]
    largest_first = np.argsort(-ownership.counts[owner, segment], kind="stable")
    owners, first = np.unique(owner[largest_first], return_index=True)
    return owners, segment[largest_first[first]]


def _of_points(
    frame_truth: FrameTruth, ranging: Ranging | None, label: Ints, owner: Ints, segment: Ints
) -> dict[str, Floats]:
    """Return the bound and the visible extents of each observation (K,); NaN without the rig's beams."""
    if ranging is None or not len(owner):
        return dict.fromkeys(("heading_bound_deg", "seen_length_m", "seen_width_m"), np.full(len(owner), np.nan))
    points = body_points.of_observations(frame_truth, ranging, label, owner, segment)
    length, width = body_points.extents(points, len(owner)).T
    limit = np.degrees(observed(frame_truth, ranging, points, owner))
    return {"heading_bound_deg": limit, "seen_length_m": length, "seen_width_m": width}


def _of_boxes(boxes: Boxes, segment: Ints) -> dict[str, Floats]:
    """Return heading and its standard deviation of the box of each segment (K,); NaN without a box of vehicle size."""
    heading, std = np.full((2, len(segment)), np.nan)
    order = np.argsort(boxes.segment, kind="stable")
    place = np.searchsorted(boxes.segment[order], segment)
    found = np.flatnonzero(np.isin(segment, boxes.segment))
    box = order[place[found]]
    heading[found] = boxes.heading[box]
    std[found] = np.degrees(np.sqrt(np.maximum(boxes.covariance[box, 2, 2], 0.0)))
    return {"box_heading_ego_rad": heading, "box_heading_std_deg": std}
