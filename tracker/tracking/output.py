"""Conversion of tracks to the `Tracks` record."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.records import MODEL_NAMES, PREDICTION_S, Tracks
from luxloop.tracker.tracking.filters import STATE_DIM
from luxloop.tracker.tracking.model_selection import ModelSelection
from luxloop.tracker.tracking.prediction import turns
from luxloop.tracker.tracking.track_table import TrackTable
from luxloop.tracker.tracking.turning import LEAST_SPEED_MPS, Complexes, turned_integrals, turning_among

REPORTED_DIM = 8
"""State of the filters, then heading and yaw rate."""


def report(tracks: TrackTable, selection: ModelSelection) -> Tracks:
    """Return one row per track, oldest first: (6) of the selected model, whose omitted states are zero."""
    count, error = len(tracks), tracks.corner_error
    mean, covariance = np.zeros((count, REPORTED_DIM)), np.zeros((count, REPORTED_DIM, REPORTED_DIM))
    mean[:, :STATE_DIM], covariance[:, :STATE_DIM, :STATE_DIM] = tracks.estimate, tracks.estimate_covariance
    mean[:, STATE_DIM:], covariance[:, STATE_DIM:, STATE_DIM:] = tracks.yaw, tracks.yaw_covariance
    covariance[:, :2, :2] += error
    return Tracks(
        id=tracks.id.copy(),
        status=tracks.status.astype(np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=tracks.probability.copy(),
        model=tracks.model,
        model_position_odom=tracks.independent_mean[:, :, :2].copy(),
        corner_sign=tracks.corner_sign.copy(),
        size=tracks.size.copy(),
        model_covariance_odom=tracks.independent_covariance[:, :, :2, :2] + error[:, None],
        model_nis=tracks.nis.copy(),
        prediction_odom=predictions(tracks, selection),
        models=tracks.models,
    )


def predictions(tracks: TrackTable, selection: ModelSelection) -> Floats:
    """(T, M + 1, H, 2) predicted corners by the independent filters, then by the bank [m]."""
    mode_time_s = np.full(len(tracks), selection.mode_time_s)
    states = tracks.independent_mean, tracks.mean, selection.weights(tracks), mode_time_s
    indices = np.array([MODEL_NAMES.index(name) for name in tracks.models])
    return np.asarray(predicted_corners(*states, *known_inputs(tracks), indices))


def known_inputs(tracks: TrackTable) -> tuple[Floats, Complexes]:
    """Return yaw rates (T,) and directions of motion (T,), for turning models; zero without them."""
    if not turning_among(tracks.models):
        return np.zeros(len(tracks)), np.zeros(len(tracks), dtype=np.complex128)
    inputs = turns(tracks)
    directions = np.array([turn.direction for turn in inputs], dtype=np.complex128)
    return np.array([turn.yaw_rate for turn in inputs]), directions


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
    return 2.0 * (elementary.expm1(-share) + share) / share**2 if share > 1e-3 else 1.0 - share / 3.0


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
