"""Errors of the velocities of tracks on labelled vehicles."""

import numpy as np

from scenarios.arrays import Floats
from scenarios.grading.frame_grade import FrameGrade
from scenarios.grading.metric_names import METRICS
from scenarios.result import Metric
from sim.world import WorldFrame
from tracker.records import Status, Tracks

NO_TRACK = "no confirmed track with a velocity followed a graded vehicle"


class MotionErrors:
    """Collects the velocity errors of confirmed tracks on graded vehicles, frame by frame.

    A track's velocity is that of its corner, the truth that of the box centre: in a turn of 0.3 rad/s they differ by up
    to 0.7 m/s.
    """

    def __init__(self) -> None:
        self._velocity: list[Floats] = []
        self._truth: list[Floats] = []

    def add(self, frame: WorldFrame, tracks: Tracks, grade: FrameGrade) -> None:
        """Add one frame; velocities are compared in the odometry frame."""
        actor = np.flatnonzero(grade.graded)
        track, row = np.nonzero(grade.track_actor[:, None] == frame.actors.id[actor])
        confirmed = tracks.status[track] == Status.CONFIRMED
        velocity = tracks.mean[track[confirmed], 2:4]
        known = np.isfinite(velocity).all(axis=1)
        self._velocity.append(velocity[known])
        self._truth.append(frame.actors.velocity_world[actor[row[confirmed]]][known])

    def metrics(self) -> dict[str, Metric]:
        """Return mean errors of velocity and speed [m/s]."""
        velocity, truth = (np.concatenate([np.empty((0, 2)), *parts]) for parts in (self._velocity, self._truth))
        speed = np.hypot(*velocity.T) - np.hypot(*truth.T)
        values = {
            "track.velocity_abs_mean_mps": np.hypot(*(velocity - truth).T),
            "track.speed_abs_mean_mps": np.abs(speed),
            "track.speed_mean_mps": speed,
        }
        return {name: _mean(name, errors) for name, errors in values.items()}


def _mean(name: str, errors: Floats) -> Metric:
    value, reason = (float(errors.mean()), "") if len(errors) else (None, NO_TRACK)
    return Metric(value, METRICS[name], len(errors), reason)
