"""The true motion mode of every actor in every frame, from its true velocity."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pandas as pd

from scenarios.grading.config import GradingConfig
from scenarios.grading.geometry import Floats
from tracker.records import MODELS

STATIONARY, CV, CA = range(len(MODELS))

Bools = npt.NDArray[np.bool_]


def true_modes(truth: pd.DataFrame, config: GradingConfig, dt: float) -> pd.Categorical:
    """Return the mode of each row of the truth table, as a category of `MODELS`; frames are `dt` apart [s]."""
    mode = np.empty(len(truth), dtype=np.int8)
    velocity = truth[["vx_world_mps", "vy_world_mps"]].to_numpy()
    time = truth["time_s"].to_numpy()
    window = max(round(config.mode_window_s / dt), 1)
    for index in truth.groupby("actor_id").indices.values():
        mode[index] = modes_of(velocity[index], time[index], config, window)
    return pd.Categorical.from_codes(mode, list(MODELS))


def modes_of(velocity: Floats, time: Floats, config: GradingConfig, window: int) -> npt.NDArray[np.int8]:
    """Modes (K,) of one actor with velocities (K, 2) [m/s] at times (K,) [s].

    The acceleration is the mean over `window` frames, from the difference of velocities: it holds turns (yaw rate
    times speed), and smooths the frame-to-frame jitter of SUMO's car-following models. Whether the actor moves and
    whether it accelerates are each settled for themselves.
    """
    frame, half = np.arange(len(time)), max(window // 2, 1)
    early, late = np.maximum(frame - half, 0), np.minimum(frame + half, len(time) - 1)
    span = np.maximum(time[late] - time[early], np.finfo(float).tiny)
    acceleration = np.linalg.norm(velocity[late] - velocity[early], axis=1) / span
    moving = settle(np.linalg.norm(velocity, axis=1) >= config.stationary_speed_mps, window)
    accelerating = settle(acceleration >= config.cv_acceleration_mps2, window)
    return np.where(moving, np.where(accelerating, CA, CV), STATIONARY).astype(np.int8)


def settle(state: Bools, hold: int) -> Bools:
    """Let the state before go on through every spell of states (K,) shorter than `hold`; the first one stands."""
    changes = np.flatnonzero(np.diff(state)) + 1
    out = state.copy()
    for start, stop in pairwise([*changes, len(state)]):
        if stop - start < hold:
            out[start:stop] = out[start - 1]
    return out
