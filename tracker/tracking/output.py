"""Conversion of tracks to the `Tracks` record."""

import math
from collections.abc import Sequence

import numpy as np

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.compiled import kernel
from luxloop.tracker.records import MODEL_NAMES, MODELS, PREDICTION_S, Tracks
from luxloop.tracker.tracking.filters import STATE_DIM, stacked
from luxloop.tracker.tracking.track import Track
from luxloop.tracker.tracking.track_arrays import offset_covariances
from luxloop.tracker.tracking.turning import LEAST_SPEED_MPS, Complexes, turned_integrals, turning_among

REPORTED_DIM = 8
"""State of the filters, then heading and yaw rate."""


def states(tracks: Sequence[Track], offset: Floats) -> tuple[Floats, Floats]:
    """Return states (T, 8) and covariances (T, 8, 8) in the order of (6); states that a selected model omits are zero.

    `offset` (T, 2, 2) is the covariance of the time-correlated error of each tracked corner [m^2].
    """
    count, turned = len(tracks), slice(STATE_DIM, None)
    mean, covariance = np.zeros((count, REPORTED_DIM)), np.zeros((count, REPORTED_DIM, REPORTED_DIM))
    if tracks:
        mean[:, :STATE_DIM], covariance[:, :STATE_DIM, :STATE_DIM] = _stacked([t.corner.bank.estimate for t in tracks])
        mean[:, turned], covariance[:, turned, turned] = _stacked([track.yaw_state for track in tracks])
    covariance[:, :2, :2] += offset
    return mean, covariance


def _stacked(states: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    """Return means (T, n) and covariances (T, n, n) of T states."""
    means, covariances = zip(*states, strict=True)
    return np.array(means), np.array(covariances)


def report(tracks: Sequence[Track], models: tuple[str, ...] = MODELS) -> Tracks:
    """Return one row per track, oldest first; `models` are the names of their filters."""
    count, m = len(tracks), len(models)
    independent = [track.corner.independent for track in tracks]
    position, of_corner = stacked([own.filters for own in independent])
    offset = offset_covariances(tracks)
    mean, covariance = states(tracks, offset)
    return Tracks(
        id=np.array([track.id for track in tracks], dtype=np.int64),
        status=np.array([track.status for track in tracks], dtype=np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=np.array([track.corner.bank.probability for track in tracks]).reshape(count, m),
        model=np.array([track.corner.model for track in tracks], dtype=np.int64),
        model_position_odom=position.reshape(count, m, STATE_DIM)[:, :, :2].copy(),
        corner_sign=np.array([track.corner.sign for track in tracks], dtype=np.int64).reshape(count, 2),
        size=np.array([track.size for track in tracks]).reshape(count, 2),
        model_covariance_odom=of_corner.reshape(count, m, STATE_DIM, STATE_DIM)[:, :, :2, :2] + offset[:, None],
        model_nis=np.array([own.nis for own in independent]).reshape(count, m),
        prediction_odom=predictions(tracks, models),
        models=models,
    )


def predictions(tracks: Sequence[Track], models: tuple[str, ...]) -> Floats:
    """(T, M + 1, H, 2) predicted corners by the independent filters, then by the bank [m]."""
    if not tracks:
        return np.zeros((0, len(models) + 1, len(PREDICTION_S), 2))
    banks = [track.corner.bank for track in tracks]
    independent = np.array([track.corner.independent.filters.mean for track in tracks])
    means, weights = np.array([bank.filters.mean for bank in banks]), np.array([bank.weights for bank in banks])
    mode_time_s, inputs = np.array([bank.mode_time_s for bank in banks]), known_inputs(tracks, models)
    indices = np.array([MODEL_NAMES.index(name) for name in models])
    return np.asarray(predicted_corners(independent, means, weights, mode_time_s, *inputs, indices))


def known_inputs(tracks: Sequence[Track], models: tuple[str, ...]) -> tuple[Floats, Complexes]:
    """Return yaw rates (T,) and directions of motion (T,), for turning models; zero without them."""
    if not turning_among(models):
        return np.zeros(len(tracks)), np.zeros(len(tracks), dtype=np.complex128)
    turns = [track.turn for track in tracks]
    directions = np.array([turn.direction for turn in turns], dtype=np.complex128)
    return np.array([turn.yaw_rate for turn in turns]), directions


CURVATURE_MAX_PER_M = 0.25
"""Curvature of the tightest path of a corner [1/m]: a radius of 4 m, inside the turning circle of a small car."""

STATIONARY, CV, CA, CTRV, CTRA, TWO_AXLE = range(len(MODEL_NAMES))
"""Indices in `MODEL_NAMES`."""


@kernel()
def predicted_corners(
    independent: Floats,
    bank: Floats,
    weight: Floats,
    mode_time_s: Floats,
    yaw_rate: Floats,
    direction: Complexes,
    models: Ints,
) -> Floats:
    """(T, M + 1, H, 2) predicted corners of T tracks by M independent filters, then by the bank [m].

    The prediction of the bank is the mean of those of its filters, by their weights. `models` (M,) are indices in
    `MODEL_NAMES`.

    Parameters
    ----------
    independent, bank
        (T, M, 6) states.
    weight
        (T, M).
    mode_time_s
        (T,) mean time in a mode of the bank [s].
    yaw_rate, direction
        (T,) known inputs of turning models, see `turning.Turn`.
    """
    count, m = weight.shape
    ahead = np.zeros((count, m + 1, len(PREDICTION_S), 2))
    for t in range(count):
        for h in range(len(PREDICTION_S)):
            time, share = PREDICTION_S[h], lasting(PREDICTION_S[h], mode_time_s[t])
            for k in range(m):
                place = position(models[k], independent[t, k], 1.0, yaw_rate[t], direction[t], time)
                ahead[t, k, h, 0], ahead[t, k, h, 1] = place.real, place.imag
                place = weight[t, k] * position(models[k], bank[t, k], share, yaw_rate[t], direction[t], time)
                ahead[t, m, h, 0] += place.real
                ahead[t, m, h, 1] += place.imag
    return ahead


@kernel()
def lasting(ahead_s: float, mode_time_s: float) -> float:
    """Return the mean displacement by an acceleration that ends at a random time, relative to one that lasts.

    With the mean time T in the mode [s], infinite for a model that never ends, the acceleration has the mean
    a exp(-t / T), whose double integral over the time h is a T^2 (exp(-h / T) + h / T - 1).
    """
    share = ahead_s / mode_time_s
    return 2.0 * (math.expm1(-share) + share) / share**2 if share > 1e-3 else 1.0 - share / 3.0


@kernel()
def position(model: int, mean: Floats, share: float, yaw_rate: float, direction: complex, ahead_s: float) -> complex:
    """Return the position of a vehicle by one model [m].

    Its acceleration has the effect of a `share` of it that lasts.
    """
    start, velocity = complex(mean[0], mean[1]), complex(mean[2], mean[3])
    acceleration = share * complex(mean[4], mean[5])
    if model == STATIONARY:
        return start
    if model == CV:
        return start + velocity * ahead_s
    if model == CTRV:
        return start + velocity * turned_integrals(yaw_rate, ahead_s)[0]
    if model == TWO_AXLE:
        return start + along_circle(velocity, acceleration, yaw_rate, direction, ahead_s)
    speed = abs(velocity)
    forward = velocity / speed if speed > 0.0 else 1.0 + 0.0j
    change = (acceleration * forward.conjugate()).real
    until = until_stop(speed, change, ahead_s)
    if model == CA:
        return start + velocity * until + 0.5 * acceleration * until**2
    first, second = turned_integrals(yaw_rate, until)
    return start + forward * (speed * first + change * second)


@kernel()
def along_circle(
    velocity: complex, acceleration: complex, yaw_rate: float, direction: complex, ahead_s: float
) -> complex:
    """Return the displacement of a two-axle vehicle [m]: with the speed, its yaw rate changes, too."""
    speed, change = (velocity * direction.conjugate()).real, (acceleration * direction.conjugate()).real
    until = until_stop(abs(speed), change * np.sign(speed), ahead_s)
    curvature = yaw_rate / speed if abs(speed) > LEAST_SPEED_MPS else 0.0
    curvature = min(max(curvature, -CURVATURE_MAX_PER_M), CURVATURE_MAX_PER_M)
    return direction * turned_integrals(curvature, speed * until + 0.5 * change * until**2)[0]


@kernel()
def until_stop(speed: float, change: float, ahead_s: float) -> float:
    """Return the time ahead, at most until the vehicle stops [s]."""
    return speed / -change if change * ahead_s < -speed else ahead_s
