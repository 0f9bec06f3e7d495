"""How well a heading can be known at all: the Cramer-Rao bound of an observation, from the true faces it shows.

A beam leaves its unit at o in a known direction u and meets a face, whose outward normal is n(h) at heading h and whose
plane is n(h) . x = d. The range is measured with a normal error of variance s^2, so that

    r = (d - n . o) / (n . u) + noise,    dr/dd = 1 / (n . u),    dr/dh = -t / (n . u),

where t is where on the face the beam ends, along it. Each range thus weighs w = 1 / (s n . u)^2: the error of the point
across its face is the range noise projected on the normal. Unknown are the heading, common to all faces of a vehicle,
and one offset d for each face, whose places are no more known than the size of the vehicle. Fisher information of h
once the offsets are eliminated (Kay 1993, Fundamentals of Statistical Signal Processing I, section 3.7; one face with
equal weights is the slope of his example 3.7, line fitting):

    I(h) = sum over faces, sum over points of w (t - mean of t on the face, weighed by w)^2.

No unbiased estimator's standard deviation is below I(h)^-1/2. What the bound leaves out (bodies that are not quite
straight, points that are not the body's, faces that are not told apart) is the estimator's to deal with.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from scenarios.arrays import Floats, Ints
from scenarios.grading.frame_truth import Instant
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.rig.rig import Rig
from sensor_model.truth import Cause
from sensor_model.visibility import MAX_CLEAN_DEPTH
from sim.world import Kind

Complexes = npt.NDArray[np.complex128]

CORNER_RADIUS_M = np.array(
    [{Kind.CAR: 0.40, Kind.SUV: 0.35, Kind.VAN: 0.25}.get(kind, 0.15) for kind in Kind], dtype=np.float64
)
"""By `Kind`: the largest that bodies are drawn with. A face is straight between its rounded corners."""

FACES = 4

BLIND = 0.5 * np.pi / np.sqrt(12.0)
"""Standard deviation of a heading drawn blindly, modulo 90 degrees [rad]; a wider bound bounds nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Ranging:
    """What a bound needs to know of a rig's U units; a scan alone tells neither its beams nor their spread."""

    origin_ego: Floats
    """(U, 3) where the beams leave [m]."""
    sigma: Floats
    """(U,) standard deviation of a range [m]; 0 where ranges are exact, and nothing bounds."""

    @classmethod
    def of(cls, rig: Rig, noise: NoiseConfig) -> "Ranging":
        """Of a rig's nominal units, with this noise."""
        scale = noise.range.sigma_scale * noise.range.enabled
        return cls(
            origin_ego=np.array([(rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m) for mount in rig.mounts]),
            sigma=np.array([scale * mount.model.range_sigma_m for mount in rig.mounts]),
        )


def observed(now: Instant, ranging: Ranging | None, label: Ints, owner: Ints, segment: Ints) -> Floats:
    """(K,) bounds of the headings of one frame's fit observations [rad]; NaN where there is none.

    None have vehicles without two clean points in their segment on one face, articulated ones that are bent at all
    (their faces have two headings), and all where `ranging` is None or exact.

    Parameters
    ----------
    label
        (N,) segment of each point.
    owner, segment
        (K,) rows of the observed actors, each at most once, and their segments.
    """
    if ranging is None or not ranging.sigma.any() or not len(owner):
        return np.full(len(owner), np.nan)
    observation = np.full(len(now.actors) + 1, -1, dtype=np.int64)  # the last is for points on nobody
    straight = np.flatnonzero(now.actors.articulation[owner] == 0.0)
    observation[owner[straight]] = straight
    of_point = observation[now.point_row]
    point = np.flatnonzero((of_point >= 0) & (label == segment[of_point]) & (now.truth.cause == Cause.CLEAN))
    points_body, beam_body = _in_body(now, ranging, point)
    row = now.point_row[point]
    face, along = on_faces(points_body, now.actors.size[row], CORNER_RADIUS_M[now.actors.kind[row]])
    across = np.where(face % 2, beam_body.imag, beam_body.real)
    across = np.where(face < 2, across, -across)
    sigma = -across * ranging.sigma[now.scan.unit[point]]
    seen = (face >= 0) & (sigma > 0.0)  # a beam meets no face from behind
    return bound(of_point[point][seen], face[seen], along[seen], sigma[seen], len(owner))


def _in_body(now: Instant, ranging: Ranging, point: Ints) -> tuple[Complexes, Complexes]:
    """True places (P,) of points on actors [m] and unit vectors (P,) of their beams, in the actors' frames.

    Both seen from above, x + iy. The ego and the actors move while the units sweep: both are taken as they were when
    the point was measured.
    """
    row, ego, actors = now.point_row[point], now.frame.ego, now.actors
    dt = now.scan.time_offset[point].astype(np.float64)
    origin = ranging.origin_ego[now.scan.unit[point]]
    beam = now.scan.points_ego[point] - origin
    beam /= np.sqrt((beam * beam).sum(axis=1))[:, None]
    true_ego = _plane(origin + now.truth.true_range[point, None] * beam)
    actor_yaw = actors.pose_world[row, 2] + dt * actors.yaw_rate[row]
    into_body = np.exp(1j * (ego.pose_world[2] + dt * ego.yaw_rate - actor_yaw))
    start = _plane(ego.pose_world - actors.pose_world)[row]
    moved = dt * _plane(ego.velocity_world - actors.velocity_world)[row]
    return true_ego * into_body + (start + moved) * np.exp(-1j * actor_yaw), _plane(beam) * into_body


def _plane(vectors: Floats) -> Complexes:
    """Vectors (N, 2) or (N, 3) as seen from above: x + iy."""
    return vectors[:, 0] + 1j * vectors[:, 1]


def on_faces(points_body: Complexes, size: Floats, corner_radius: Floats) -> tuple[Ints, Floats]:
    """Face (P,) that each point lies on and how far along it (P,) [m]; rounded corners are of no face.

    Faces are 0 to 3: front, left, rear and right; -1 stands for none.

    Parameters
    ----------
    points_body
        (P,) x + iy [m].
    size, corner_radius
        (P, 2) length and width first, and (P,) of the point's own vehicle [m].
    """
    x, y = points_body.real, points_body.imag
    from_end, from_side = 0.5 * size[:, 0] - np.abs(x), 0.5 * size[:, 1] - np.abs(y)
    at_end = (np.abs(from_end) <= MAX_CLEAN_DEPTH) & (from_side >= corner_radius)
    at_side = (np.abs(from_side) <= MAX_CLEAN_DEPTH) & (from_end >= corner_radius)
    end, side = np.where(x > 0.0, 0, 2), np.where(y > 0.0, 1, 3)
    face = np.where(at_end, end, np.where(at_side, side, -1))
    return face, np.where(at_end, y, x)


def bound(observation: Ints, face: Ints, along: Floats, sigma: Floats, count: int) -> Floats:
    """Cramer-Rao bound (count,) of the headings of observations [rad]; NaN where nothing tells the heading.

    Parameters
    ----------
    observation, face
        (P,) whose points they are, and on which of its faces, 0 to 3.
    along
        (P,) where on the face, along it [m].
    sigma
        (P,) standard deviation of the point across its face [m].
    """
    group, groups = observation * FACES + face, count * FACES
    weight = sigma**-2.0
    total = np.bincount(group, weight, groups)
    center = np.bincount(group, weight * along, groups) / np.where(total > 0.0, total, 1.0)
    spread = np.bincount(group, weight * (along - center[group]) ** 2, groups)
    information = spread.reshape(count, FACES).sum(axis=1)
    told = information > BLIND**-2.0
    return np.where(told, np.where(told, information, 1.0) ** -0.5, np.nan)
