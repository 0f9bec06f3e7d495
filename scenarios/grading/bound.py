"""Lower bound of the heading error of an observation, from its true points on faces of unknown position and bow.

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

import numpy as np

from luxloop.scenarios.arrays import Bools, Floats, Ints
from luxloop.scenarios.grading.body_points import BodyPoints, Complexes, Ranging
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.sensor_model.truth import Cause
from luxloop.sensor_model.visibility import MAX_CLEAN_DEPTH
from luxloop.sim.world import Kind

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
    sigma = ranging.sigma[scan.unit[points.point]] * _incidence(points.beam, face)
    kept = (sigma > 0.0) & ~actors.joint_angles[points.row].any(axis=1)  # a beam meets no face from behind
    place = along / (0.5 * BOW_SHARE[face] * actors.size[points.row, 1 - face % 2])
    return bound(points.observation[kept], face[kept], along[kept], place[kept], sigma[kept], len(owner))


def _incidence(beam: Complexes, face: Ints) -> Floats:
    """Cosine (P,) of the angle between each beam and the inward normal of its face, in the plane."""
    return np.asarray(-(beam * NORMALS[face].conj()).real)


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
