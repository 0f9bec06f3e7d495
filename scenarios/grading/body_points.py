"""True positions of the points of one frame's fit observations, in the frames of their vehicles."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sensor_model.truth import Cause

Complexes = npt.NDArray[np.complex128]

IS_ON_BODY = np.isin(np.arange(len(Cause)), (Cause.CLEAN, Cause.LAYER_OVERLAP, Cause.DOUBLED))
"""True for causes of points on the body, by `Cause`: on its outline, deeper, or displaced by errors of calibration."""


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


@dataclass(frozen=True, slots=True, eq=False)
class BodyPoints:
    """Points (P,) on the bodies of observed vehicles, as bird's-eye views x + iy."""

    point: Ints
    """(P,) index of the scan's point."""
    observation: Ints
    """(P,) observation of the point."""
    row: Ints
    """(P,) row of its actor."""
    position: Complexes
    """(P,) true position in the actor's frame [m]."""
    beam: Complexes
    """(P,) bird's-eye view of the beam's unit vector in the actor's frame."""


def of_observations(frame_truth: FrameTruth, ranging: Ranging, label: Ints, owner: Ints, segment: Ints) -> BodyPoints:
    """Return the points that lie on the body of an observed vehicle and in its segment.

    Parameters
    ----------
    label
        (N,) segment of each point.
    owner, segment
        (K,) rows of the observed actors, without repetition, and their segments.
    """
    observation = np.full(len(frame_truth.actors) + 1, -1, dtype=np.int64)  # the last is for points on no actor
    observation[owner] = np.arange(len(owner))
    of_point = observation[frame_truth.point_row]
    own = (of_point >= 0) & (label == np.append(segment, -1)[of_point])
    point = np.flatnonzero(own & IS_ON_BODY[frame_truth.truth.cause])
    position, beam = _in_body(frame_truth, ranging, point)
    return BodyPoints(point, of_point[point], frame_truth.point_row[point], position, beam)


def _in_body(frame_truth: FrameTruth, ranging: Ranging, point: Ints) -> tuple[Complexes, Complexes]:
    """True positions (P,) of points on actors [m] and unit vectors (P,) of their beams, in the actors' frames.

    The motion of the ego and of the actors during the sweep is included: both have the pose of the time at which the
    point was measured.
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


def extents(points: BodyPoints, count: int) -> Floats:
    """(count, 2) visible length and width of observations: extents of their true points along the vehicle's axes [m].

    Observations without points have NaN.
    """
    seen = np.full((count, 2), np.nan)
    for axis, values in enumerate((points.position.real, points.position.imag)):
        low, high = np.full(count, np.inf), np.full(count, -np.inf)
        np.minimum.at(low, points.observation, values)
        np.maximum.at(high, points.observation, values)
        seen[:, axis] = np.where(high >= low, high - low, np.nan)
    return seen
