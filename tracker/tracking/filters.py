"""Kalman filters of the filter bank, equations (6) to (9), as batches of arrays.

The paper's three models are a chain of integrators per axis, of order 1 (position), 2 (velocity) or 3 (acceleration).
Models of turning vehicles have transitions that depend on the track, see `luxloop.tracker.tracking.turning`. Every
filter holds all six states x, y, vx, vy, ax, ay. States that a model omits keep a prior covariance; other models start
from it when mixing. One call of a kernel updates any number of filters. filterpy is the reference in the tests, and
runs the methods `imm` and `paper`, see `luxloop.tracker.tracking.model_selection`.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from luxloop.arrays import Floats
from luxloop.compiled import kernel
from luxloop.tracker.bounds import require_within
from luxloop.tracker.records import MODEL_NAMES

STATE_DIM = 6
"""x, y, vx, vy, ax, ay [m, s]."""

ModelName = Literal["stationary", "cv", "ca", "ctrv", "ctra", "two-axle"]

ORDERS = dict(zip(MODEL_NAMES, (1, 2, 3, 2, 3, 3), strict=True))
"""Order of the highest derivative that each model estimates; it omits the higher ones."""


DRIFT_DENSITY_M2PS = 4e-4
"""Stationary model: the visible corner of a stationary vehicle drifts by about 2 cm in a second, as the view of its
rounded end changes [m^2/s]."""

ACCELERATION_TIME_S = 1.0
"""Its correlation time [s]; the spectral density is 2 x 0.1^2 x 1 = 0.02 m^2/s^3."""

JERK_TIME_S = 0.5
"""Its correlation time, the duration of a pedal movement [s]; the spectral density is 2 x 1^2 x 0.5 = 1 m^2/s^5."""

YAW_ACCELERATION_STD_RADPS2 = 0.6
"""Heading filter: yaw acceleration into a turn of 10 m radius at 6 m/s, to 0.6 rad/s in one second [rad/s^2]."""

YAW_ACCELERATION_TIME_S = 0.04
"""Its correlation time, half a scan period because steering is independent from scan to scan [s]; the spectral
density is 2 x 0.6^2 x 0.04 = 0.029 rad^2/s^3."""

STARTING_SPEED_STD_MPS = 0.6
"""Standard deviation of the speed at the change from stationary to moving [m/s]: what a vehicle gains at
`MANOEUVRE_STD_MPS2` in the five scans before its motion is evident."""

MANOEUVRE_STD_MPS2 = 1.5
"""Standard deviation of the acceleration at the start of a manoeuvre; comfortable driving stays below 2 to 3
[m/s^2]."""

INITIAL_YAW_RATE_STD_RADPS = 0.2
"""Standard deviation of the initial yaw rate [rad/s]."""


@dataclass(frozen=True, slots=True)
class FilterConfig:
    """Process noise, initial covariance and noise floors of the filter bank.

    The process noise models the motion that a model omits. That motion is time-correlated, not white: an acceleration
    of standard deviation s with correlation time T acts on the velocity as white noise of spectral density 2 s^2 T over
    intervals longer than T (Singer 1970; Bar-Shalom, Li, Kirubarajan 2001, section 8.2). The densities do not depend on
    the rate of observations.
    """

    models: tuple[ModelName, ...] = ("stationary", "cv", "ca")
    """Motion models of the bank, each once. `ctrv` turns at a constant rate with constant speed, `ctra` with a constant
    change of speed, and `two-axle` is the kinematic single-track model. Change it to compare models."""
    acceleration_std_mps2: float = 0.1
    """Constant velocity model: unintended acceleration of a driver who keeps the speed [m/s^2]. Following drivers
    oscillate by about 0.2 without noticing (Wiedemann 1974): two standard deviations. Increase it for racing drivers
    or rough traffic."""
    jerk_std_mps3: float = 1.0
    """Constant acceleration model: jerk; ordinary driving stays below 2 to 3, at least two standard deviations
    [m/s^3]. Increase it for emergency braking, if tracks lag behind it."""
    heading: Literal["adaptive", "paper"] = "adaptive"
    """`adaptive`: the noise of the yaw rate follows from the speed, and outliers are weighed by their probability.
    `paper`: constant noise, `YAW_ACCELERATION_STD_RADPS2`, a yaw rate of zero in all models but constant acceleration,
    and the gate `HEADING_GATE_SIGMA`. Change it to compare with the paper."""
    initial_speed_std_mps: float = 8.0
    """Standard deviation of the initial speed: urban traffic up to 60 km/h is two standard deviations [m/s].
    Increase it for motorways with much oncoming traffic."""
    position_std_floor_m: float = 0.007
    """Corner noise that the fit does not model: beams meet the outline at other places in each scan [m]. Increase it
    with the beam spacing."""
    heading_std_floor_rad: float = 0.02
    """Heading noise that the fit does not model [rad]. Increase it if headings follow the noise of your sensor."""

    def __post_init__(self) -> None:
        if not self.models or len(set(self.models)) < len(self.models):
            raise ValueError(f"models is {list(self.models)}; name one model or more, each once")
        require_within(self, 1e-9, 1e3, "acceleration_std_mps2", "jerk_std_mps3")
        require_within(self, 1e-6, 1e3, "initial_speed_std_mps", "position_std_floor_m", "heading_std_floor_rad")


def integrator(order: int, dt: float) -> Floats:
    """(order, order) transition matrix of a chain of integrators: the one-axis block of (7), (8) and (9)."""
    chain = np.eye(order)
    if order > 1:
        chain[0, 1] = dt
    if order > 2:
        chain[1, 2], chain[0, 2] = dt, dt**2 / 2
    return chain


def density(order: int, config: FilterConfig) -> float:
    """Spectral density of the position derivative that a model of this order assumes to be white noise."""
    return (
        DRIFT_DENSITY_M2PS,
        2 * config.acceleration_std_mps2**2 * ACCELERATION_TIME_S,
        2 * config.jerk_std_mps3**2 * JERK_TIME_S,
    )[order - 1]


def process_noise(order: int, dt: float, spectral_density: float) -> Floats:
    """(order, order) one-axis process noise of a chain of integrators driven by white noise of its highest derivative.

    Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), 6.2.
    """
    integrations = range(order - 1, -1, -1)  # from the noise to each derivative

    def element(i: int, j: int) -> float:
        power = i + j + 1
        return math.prod(power * [dt]) / (power * math.factorial(i) * math.factorial(j)) * spectral_density

    return np.array([[element(i, j) for j in integrations] for i in integrations])


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Transition matrices and process noise of K filters of n states for one time step."""

    transition: Floats
    """(K, n, n)."""
    noise: Floats
    """(K, n, n)."""


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Motion models of all tracks for one time step."""

    dt: float
    """[s]."""
    names: tuple[str, ...]
    """(M,) models."""
    models: Step
    """Step of M filters of 6 states, one per model; turning models go straight on, see `tracker.tracking.turning`."""
    heading: Step
    """Step of one filter of heading and yaw rate."""


@lru_cache(maxsize=8)
def motion(dt: float, config: FilterConfig) -> Motion:
    """Return equations (7), (8) and (9) for a time step `dt` [s]; cached, because scans have a constant period."""
    axes, prior = np.eye(2), prior_variances()
    transition, noise = np.zeros((2, len(config.models), 3, 3))
    for m, order in enumerate(ORDERS[name] for name in config.models):
        transition[m, :order, :order] = integrator(order, dt)
        noise[m] = np.diag(np.where(np.arange(3) < order, 0.0, prior))
        noise[m, :order, :order] = process_noise(order, dt, density(order, config))
    turning = 2 * YAW_ACCELERATION_STD_RADPS2**2 * YAW_ACCELERATION_TIME_S
    return Motion(
        dt=dt,
        names=config.models,
        models=Step(np.asarray(np.kron(transition, axes)), np.asarray(np.kron(noise, axes))),
        heading=Step(integrator(2, dt)[None], process_noise(2, dt, turning)[None]),
    )


def prior_variances() -> Floats:
    """(3,) prior variance of position, velocity and acceleration in models that omit them."""
    return np.square([0.0, STARTING_SPEED_STD_MPS, MANOEUVRE_STD_MPS2])


def initial_filters(position: Floats, covariance: Floats, config: FilterConfig) -> tuple[Floats, Floats]:
    """Return means (M, 6) and covariances (M, 6, 6) after a first observation (2,) [m] with covariance (2, 2) [m^2]."""
    mean, variance = np.zeros((len(config.models), STATE_DIM)), initial_covariances(config).copy()
    mean[:, :2], variance[:, :2, :2] = position, covariance
    return mean, variance


@lru_cache(maxsize=8)
def initial_covariances(config: FilterConfig) -> Floats:
    """(M, 6, 6) prior covariances of the filters of a new track, one per model."""
    prior = np.square([0.0, config.initial_speed_std_mps, MANOEUVRE_STD_MPS2])
    return np.tile(np.diag(np.repeat(prior, 2)), (len(config.models), 1, 1))


def moved(offset: Floats, yaw_rate: float) -> Floats:
    """(6,) change of the state when another point of a rigid body is tracked, `offset` (2,) [m] away.

    At a yaw rate [rad/s] the point has another velocity, and an acceleration towards the centre of the turn.
    """
    x, y = offset
    return np.array([x, y, -yaw_rate * y, yaw_rate * x, -(yaw_rate**2) * x, -(yaw_rate**2) * y])


@kernel()
def predict_rows(mean: Floats, covariance: Floats, transition: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (K, n) and covariances (K, n, n) after one time step.

    Transitions and process noise (S, n, n) repeat after S filters.
    """
    count, n = mean.shape
    moved, spread = np.zeros((count, n)), np.empty((count, n, n))
    half = np.empty((n, n))
    for k in range(count):
        f, q = transition[k % len(transition)], noise[k % len(noise)]
        for i in range(n):
            for j in range(n):
                half[i, j] = 0.0
            for j in range(n):
                if f[i, j] != 0.0:  # transitions are sparse
                    moved[k, i] += f[i, j] * mean[k, j]
                    for m in range(n):
                        half[i, m] += f[i, j] * covariance[k, j, m]
        for i in range(n):
            for j in range(n):
                spread[k, i, j] = q[i, j]
        for j in range(n):
            for m in range(n):
                if f[j, m] != 0.0:
                    for i in range(n):
                        spread[k, i, j] += half[i, m] * f[j, m]
    return moved, spread


@kernel()
def correct_rows(mean: Floats, covariance: Floats, residual: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """Return the means (K, n) and covariances (K, n, n) after a measurement of the first one or two states.

    Innovations are (K, m), and the measurement noise (S, m, m) is that of K / S successive filters each.
    """
    count, n = mean.shape
    corrected, spread = np.empty((count, n)), np.empty((count, n, n))
    for k in range(count):
        r = noise[k * len(noise) // count]
        gain = gains(covariance[k], r)
        for i in range(n):
            corrected[k, i] = mean[k, i]
            for m in range(len(r)):
                corrected[k, i] += gain[i, m] * residual[k, m]
            for j in range(i + 1):
                low, high = covariance[k, i, j], covariance[k, j, i]
                for m in range(len(r)):
                    low -= gain[i, m] * covariance[k, m, j]
                    high -= gain[j, m] * covariance[k, m, i]
                spread[k, i, j] = spread[k, j, i] = 0.5 * (low + high)
    return corrected, spread


@kernel()
def gains(covariance: Floats, noise: Floats) -> Floats:
    """(n, m) Kalman gain of a measurement of the first one or two states, with noise (m, m)."""
    n, m = len(covariance), len(noise)
    gain = np.empty((n, m))
    xx = covariance[0, 0] + noise[0, 0]
    if m == 1:
        for i in range(n):
            gain[i, 0] = covariance[i, 0] / xx
        return gain
    xy, yy = covariance[0, 1] + noise[0, 1], covariance[1, 1] + noise[1, 1]
    determinant = xx * yy - xy * xy
    for i in range(n):
        gain[i, 0] = (covariance[i, 0] * yy - covariance[i, 1] * xy) / determinant
        gain[i, 1] = (covariance[i, 1] * xx - covariance[i, 0] * xy) / determinant
    return gain
