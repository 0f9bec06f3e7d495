"""Accuracy of the selected motion model against the true mode of the vehicle."""

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.result import NOT_REPORTED
from luxloop.tracker.records import MODEL_NAMES, MODELS, TURNING_MODELS

MODE_OF = {**{model: model for model in MODELS}, **dict.fromkeys(TURNING_MODELS, "ca")}
"""True mode that each model describes: a turn is an acceleration."""

NO_MODEL = f"{NOT_REPORTED} the selected model"

STANDING_MPS = 0.5
"""[m/s] A track without a model stands below this speed: a walking person is three times as fast."""


MODE_CODES = np.array([MODELS.index(MODE_OF[model]) for model in MODEL_NAMES])
"""Index of the true mode that each model of `MODEL_NAMES` describes."""


def described_mode(model: pd.Series) -> npt.NDArray[np.int64]:
    """(K,) index in `MODELS` of the mode that each selected model describes; -1 for unknown models."""
    return np.asarray(np.append(MODE_CODES, -1)[model.cat.codes.to_numpy()], dtype=np.int64)


def column(tracks: pd.DataFrame, name: str) -> npt.NDArray[Any] | None:
    """Return a column (K,) about the selected model of judged tracks, NaN without one; None for other names.

    A track without a model stands or moves by its speed.
    """
    model = tracks["model"]
    if name == "right_mode":
        right = described_mode(model) == tracks["true_mode"].cat.codes.to_numpy()
        return np.where(model.isna(), np.nan, right)
    if name.startswith("selected_"):
        return np.where(model.isna(), np.nan, model == name.removeprefix("selected_"))
    if name != "right_motion":
        return None
    speed = np.hypot(*tracks[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64).T)
    stands = np.where(model.notna(), model.to_numpy(object) == MODELS[0], speed < STANDING_MPS)
    known = (model.notna() | np.isfinite(speed)).to_numpy()
    return np.where(known, stands == (tracks["true_mode"] == MODELS[0]), np.nan)


def switch_latencies(judged: pd.DataFrame) -> list[tuple[int, float]]:
    """Return the vehicle of each change of the true mode, and the frames until its selection.

    Infinite if the mode is not selected before the next change. A change counts if the vehicle is followed in the frame
    of the change and in the previous one.
    """
    latencies: list[tuple[int, float]] = []
    for actor_id, rows in judged.sort_values("frame", kind="stable").groupby("actor_id"):
        frame = rows["frame"].to_numpy()
        mode, model = rows["true_mode"].cat.codes.to_numpy(), described_mode(rows["model"])
        changes = np.flatnonzero(np.diff(mode)) + 1
        for start, stop in pairwise([*changes, len(mode)]):
            if frame[start] - frame[start - 1] == 1:
                agrees = start + np.flatnonzero(model[start:stop] == mode[start])
                wait = float(frame[agrees[0]] - frame[start]) if len(agrees) else np.inf
                latencies.append((int(actor_id), wait))
    return latencies
