"""Prediction of all tracks to the time of a scan."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.tracker.tracking import corner, mma
from luxloop.tracker.tracking.existence import existence
from luxloop.tracker.tracking.filters import Motion, Step
from luxloop.tracker.tracking.heading import heading_filter
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.track_config import TrackConfig
from luxloop.tracker.tracking.track_table import COASTING, DEAD, TENTATIVE, TrackTable
from luxloop.tracker.tracking.turning import (
    Turn,
    axle_to_corner,
    motion_direction,
    turning_among,
    with_turn,
    with_turning_acceleration,
)


def predict(tracks: TrackTable, motion: Motion, selection: ModelSelection, config: TrackConfig) -> None:
    """Move tracks on by one time step; terminate those that were not seen for too long.

    Of the paper's models, only constant acceleration lets a vehicle turn: the others set its yaw rate to zero. With a
    turning model in the bank only the stationary one does.
    """
    if not len(tracks):
        return
    model = tracks.model
    turning = np.array([name == "ca" for name in tracks.models])[model]
    own = [motion] * len(tracks)
    if turning_among(motion.names):
        turning = np.array([name != "stationary" for name in tracks.models])[model]
        own = [with_turn(motion, turn) for turn in turns(tracks)]
    heading_filter(config.filters).predict(tracks, motion, corner.speeds(tracks), turning)
    of_banks = stacked(bank_motions(tracks, own, config))
    tracks.unobserved_s += motion.dt
    tracks.age_s += motion.dt
    wait(tracks, motion.dt, config)
    alone = stacked(own)
    tracks.independent_mean, tracks.independent_covariance = mma.move(
        tracks.independent_mean, tracks.independent_covariance, alone.transition, alone.noise
    )
    tracks.nis[:] = np.nan
    selection.predict(tracks, of_banks, motion.dt)


def turns(tracks: TrackTable) -> list[Turn]:
    """Return the known inputs of turning models of each track."""
    inputs = []
    for t, velocity in enumerate(tracks.velocity.tolist()):
        (heading, yaw_rate), variance = tracks.yaw[t].tolist(), tracks.yaw_covariance[t]
        direction = motion_direction(complex(*velocity), heading, yaw_rate, from_axle(tracks, t))
        inputs.append(Turn(yaw_rate, variance[1, 1], variance[0, 0], complex(*velocity), direction))
    return inputs


def from_axle(tracks: TrackTable, t: int) -> complex:
    """Return the vector from the middle of the rear axle to the tracked corner, odometry frame [m]."""
    return axle_to_corner(tracks.corner_sign[t], tracks.size[t]) * elementary.rotation(tracks.yaw.item(t, 0))


def bank_motions(tracks: TrackTable, own: list[Motion], config: TrackConfig) -> list[Motion]:
    """Return the motion of each bank, in which `ca` turns with the vehicle; independent filters go straight on."""
    if config.filters.heading == "paper":
        return own
    filtered, stationary = heading_filter(config.filters), tracks.stationary.tolist()
    motions = []
    for t, velocity in enumerate(tracks.velocity.tolist()):
        turn = filtered.yaw_rate(tracks, t)
        jerk = config.filters.jerk_std_mps3
        straight = own[t] if stationary[t] else with_turning_acceleration(own[t], *turn, complex(*velocity), jerk)
        motions.append(straight)
    return motions


def stacked(motions: list[Motion]) -> Step:
    """Return transitions and noise of the M filters of T motions, (T * M, n, n), or (M, n, n) if all are the same."""
    first = motions[0]
    if all(motion is first for motion in motions):
        return first.models
    transition: Floats = np.concatenate([motion.models.transition for motion in motions])
    return Step(transition, np.concatenate([motion.models.noise for motion in motions]))


def wait(tracks: TrackTable, dt: float, config: TrackConfig) -> None:
    """Let tracks coast that were not seen for a while; terminate them in the end.

    A tentative track counts the time that it was not seen before this scan, `dt` [s] after the last one.
    """
    for t, (status, unobserved_s) in enumerate(zip(tracks.status.tolist(), tracks.unobserved_s.tolist(), strict=True)):
        if status == TENTATIVE:
            if unobserved_s - dt > config.confirmation.tentative_coast_s:
                tracks.status[t] = DEAD
        elif existence(unobserved_s, 1.0, config.existence) < config.existence.existence_min:
            tracks.status[t] = DEAD
        elif unobserved_s > config.confirmation.gap_s:
            tracks.status[t] = COASTING
