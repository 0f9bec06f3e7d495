"""Cramer-Rao bound of the heading error of an observation, from the true faces with points on them.

A beam leaves its unit at o in a known direction u and meets a face, whose outward normal is n(h) at heading h and whose
plane is n(h) . x = d. The range is measured with a normal error of variance s^2, so that

    r = (d - n . o) / (n . u) + noise,    dr/dd = 1 / (n . u),    dr/dh = -t / (n . u),

where t is the position of the beam's end along the face. The weight of each range is w = 1 / (s n . u)^2, because the
error of the point across its face is the range noise projected on the normal. The unknowns are the heading, common to
all faces of a vehicle, and one offset d per face, because the size of the vehicle is unknown. The Fisher information of
h after elimination of the offsets is (Kay 1993, Fundamentals of Statistical Signal Processing I, section 3.7; one face
with equal weights is the slope of his example 3.7, line fitting):

    I(h) = sum over faces, sum over points of w (t - mean of t on the face, weighted by w)^2.

No unbiased estimator has a standard deviation below I(h)^-1/2. The bound ignores curved bodies, points of other objects
and the assignment of points to faces; an estimator also has to cope with these.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Floats, Ints
from scenarios.grading.frame_truth import FrameTruth
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.rig.rig import Rig
from sensor_model.truth import Cause
from sensor_model.visibility import MAX_CLEAN_DEPTH
from sim.world import Kind

Complexes = npt.NDArray[np.complex128]

CORNER_RADIUS_M = np.array(
    [{Kind.CAR: 0.25, Kind.SUV: 0.25, Kind.VAN: 0.27}.get(kind, 0.15) for kind in Kind], dtype=np.float64
)
"""Largest corner radius of a body by `Kind` [m]. A bevel of width w replaces an arc of radius w / (2 tan(22.5 deg)).
A face is taken as straight between its rounded corners, although those of cars are bowed."""

FACES = 4

UNIFORM_STD = 0.5 * np.pi / np.sqrt(12.0)
"""Standard deviation of a uniformly random heading modulo 90 degrees [rad]. A larger bound has no meaning."""


@dataclass(frozen=True, slots=True, eq=False)
class Ranging:
    """Beam origins and range noise of a rig's U units, which a scan does not contain."""

    origin_ego: Floats
    """(U, 3) beam origins in the ego frame [m]."""
    sigma: Floats
    """(U,) standard deviation of a range [m]. Exact ranges have 0, and then there is no bound."""

    @classmethod
    def of(cls, rig: Rig, noise: NoiseConfig) -> "Ranging":
        """Take the nominal units of a rig with the range noise of `noise`."""
        scale = noise.range.sigma_scale * noise.range.enabled
        return cls(
            origin_ego=np.array([(rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m) for mount in rig.mounts]),
            sigma=np.array([scale * mount.model.range_sigma_m for mount in rig.mounts]),
        )


def observed(frame_truth: FrameTruth, ranging: Ranging | None, label: Ints, owner: Ints, segment: Ints) -> Floats:
    """(K,) bounds of the headings of one frame's fit observations [rad].

    NaN for vehicles without two clean points of their segment on one face, for trucks that are bent at all (their faces
    have two headings), and for all where `ranging` is None or exact.

    Parameters
    ----------
    label
        (N,) segment of each point.
    owner, segment
        (K,) rows of the observed actors, without repetition, and their segments.
    """
    if ranging is None or not ranging.sigma.any() or not len(owner):
        return np.full(len(owner), np.nan)
    observation = np.full(len(frame_truth.actors) + 1, -1, dtype=np.int64)  # the last is for points on no actor
    straight = np.flatnonzero(frame_truth.actors.articulation[owner] == 0.0)
    observation[owner[straight]] = straight
    of_point = observation[frame_truth.point_row]
    point = np.flatnonzero((of_point >= 0) & (label == segment[of_point]) & (frame_truth.truth.cause == Cause.CLEAN))
    points_body, beam_body = _in_body(frame_truth, ranging, point)
    row = frame_truth.point_row[point]
    face, along = on_faces(points_body, frame_truth.actors.size[row], CORNER_RADIUS_M[frame_truth.actors.kind[row]])
    across = np.where(face % 2, beam_body.imag, beam_body.real)
    across = np.where(face < 2, across, -across)
    sigma = -across * ranging.sigma[frame_truth.scan.unit[point]]
    seen = (face >= 0) & (sigma > 0.0)  # a beam meets no face from behind
    return bound(of_point[point][seen], face[seen], along[seen], sigma[seen], len(owner))


def _in_body(frame_truth: FrameTruth, ranging: Ranging, point: Ints) -> tuple[Complexes, Complexes]:
    """True positions (P,) of points on actors [m] and unit vectors (P,) of their beams, in the actors' frames.

    Both are bird's-eye views, x + iy. The motion of the ego and of the actors during the sweep is included: both have
    the pose of the time at which the point was measured.
    """
    row, ego, actors = frame_truth.point_row[point], frame_truth.frame.ego, frame_truth.actors
    dt = frame_truth.scan.time_offset[point].astype(np.float64)
    origin = ranging.origin_ego[frame_truth.scan.unit[point]]
    beam = frame_truth.scan.points_ego[point] - origin
    beam /= np.sqrt((beam * beam).sum(axis=1))[:, None]
    true_ego = _plane(origin + frame_truth.truth.true_range[point, None] * beam)
    actor_yaw = actors.pose_world[row, 2] + dt * actors.yaw_rate[row]
    into_body = np.exp(1j * (ego.pose_world[2] + dt * ego.yaw_rate - actor_yaw))
    start = _plane(ego.pose_world - actors.pose_world)[row]
    moved = dt * _plane(ego.velocity_world - actors.velocity_world)[row]
    return true_ego * into_body + (start + moved) * np.exp(-1j * actor_yaw), _plane(beam) * into_body


def _plane(vectors: Floats) -> Complexes:
    """Bird's-eye view x + iy of vectors (N, 2) or (N, 3)."""
    return vectors[:, 0] + 1j * vectors[:, 1]


def on_faces(points_body: Complexes, size: Floats, corner_radius: Floats) -> tuple[Ints, Floats]:
    """Return the face (P,) of each point and its position along the face (P,) [m].

    Faces are 0 to 3: front, left, rear and right. Points on rounded corners and off the outline have -1.

    Parameters
    ----------
    points_body
        (P,) points x + iy in the frame of their vehicle [m].
    size, corner_radius
        (P, 2) or more, length and width first, and (P,), of the point's vehicle [m].
    """
    x, y = points_body.real, points_body.imag
    from_end, from_side = 0.5 * size[:, 0] - np.abs(x), 0.5 * size[:, 1] - np.abs(y)
    at_end = (np.abs(from_end) <= MAX_CLEAN_DEPTH) & (from_side >= corner_radius)
    at_side = (np.abs(from_side) <= MAX_CLEAN_DEPTH) & (from_end >= corner_radius)
    end, side = np.where(x > 0.0, 0, 2), np.where(y > 0.0, 1, 3)
    face = np.where(at_end, end, np.where(at_side, side, -1))
    return face, np.where(at_end, y, x)


def bound(observation: Ints, face: Ints, along: Floats, sigma: Floats, count: int) -> Floats:
    """(count,) Cramer-Rao bounds of the headings of observations [rad]; NaN without information about the heading.

    Parameters
    ----------
    observation, face
        (P,) observation of each point, and its face, 0 to 3.
    along
        (P,) position along the face [m].
    sigma
        (P,) standard deviation of the point across its face [m].
    """
    group, groups = observation * FACES + face, count * FACES
    weight = sigma**-2.0
    total = np.bincount(group, weight, groups)
    center = np.bincount(group, weight * along, groups) / np.where(total > 0.0, total, 1.0)
    spread = np.bincount(group, weight * (along - center[group]) ** 2, groups)
    information = spread.reshape(count, FACES).sum(axis=1)
    bounded = information > UNIFORM_STD**-2.0
    return np.where(bounded, np.where(bounded, information, 1.0) ** -0.5, np.nan)
