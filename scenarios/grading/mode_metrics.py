"""Accuracy of the selected motion model against the true mode of the vehicle."""

from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.mma_metrics import MODE_OF, NO_PAIR
from luxloop.scenarios.result import NOT_REPORTED
from luxloop.tracker.records import MODEL_NAMES, MODELS

NO_MODEL = f"{NOT_REPORTED} the selected model"

STANDING_MPS = 0.5
"""[m/s] A track without a model stands below this speed: a walking person is three times as fast."""


MODE_CODES = np.array([MODELS.index(MODE_OF[model]) for model in MODEL_NAMES])
"""Index of the true mode that each model of `MODEL_NAMES` describes."""


def described_mode(model: pd.Series) -> npt.NDArray[np.int64]:
    """(K,) index in `MODELS` of the mode that each selected model describes; -1 for unknown models."""
    return np.asarray(np.append(MODE_CODES, -1)[model.cat.codes.to_numpy()], dtype=np.int64)


def grade(sheet: MetricSheet, tracks: pd.DataFrame, models: Sequence[str]) -> None:
    """Enter the accuracy, the confusions and the switch latency from the judged rows of the track table.

    Confusions are shares of the frames of each true mode.
    """
    known = tracks["model"].notna()
    judged, no_pair = tracks[tracks["judged"] & known], NO_PAIR if known.all() else NO_MODEL
    vehicle = judged["actor_id"].to_numpy()
    true, chosen = judged["true_mode"].to_numpy(object), judged["model"].to_numpy(object)
    right = described_mode(judged["model"]) == judged["true_mode"].cat.codes.to_numpy()
    sheet.mean("mma.mode_accuracy", right, no_pair, vehicle)
    _grade_standing(sheet, tracks[tracks["judged"]])
    for mode, model in product(MODELS, models):
        why = f"{no_pair} in the mode {mode}"
        sheet.mean(f"mma.confusion.{mode}.{model}", chosen[true == mode] == model, why, vehicle[true == mode])
    _grade_latency(sheet, switch_latencies(judged), "no followed vehicle changed its mode" if known.all() else NO_MODEL)


def _grade_standing(sheet: MetricSheet, judged: pd.DataFrame) -> None:
    """Enter the decision on standing or moving: by the selected model, without one by the speed of the track."""
    model = judged["model"]
    speed = np.hypot(*judged[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64).T)
    stands = np.where(model.notna(), model.to_numpy(object) == MODELS[0], speed < STANDING_MPS)
    known = (model.notna() | np.isfinite(speed)).to_numpy()
    right = (stands == (judged["true_mode"] == MODELS[0]))[known]
    why = f"{NOT_REPORTED} a model or a velocity" if len(judged) else NO_PAIR
    sheet.mean("mma.stationary_accuracy", right.to_numpy(), why, judged["actor_id"].to_numpy()[known])


def switch_latencies(judged: pd.DataFrame) -> Floats:
    """Return the frames from each change of the true mode to its selection.

    Infinite if the mode is not selected before the next change. A change counts if the vehicle is followed in the frame
    of the change and in the previous one.
    """
    latencies: list[float] = []
    for _, rows in judged.sort_values("frame", kind="stable").groupby("actor_id"):
        frame = rows["frame"].to_numpy()
        mode, model = rows["true_mode"].cat.codes.to_numpy(), described_mode(rows["model"])
        changes = np.flatnonzero(np.diff(mode)) + 1
        for start, stop in pairwise([*changes, len(mode)]):
            if frame[start] - frame[start - 1] == 1:
                agrees = start + np.flatnonzero(model[start:stop] == mode[start])
                latencies.append(float(frame[agrees[0]] - frame[start]) if len(agrees) else np.inf)
    return np.array(latencies)


def _grade_latency(sheet: MetricSheet, latencies: Floats, why: str) -> None:
    median = None
    if len(latencies):
        median = float(np.median(latencies))
    if median == np.inf:
        why, median = "half of the changes of mode or more were never selected", None
    sheet.write("mma.switch_latency_frames", median, len(latencies), why)
