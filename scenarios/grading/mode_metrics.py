"""Accuracy of the selected motion model against the true mode of the vehicle."""

from itertools import pairwise, product

import numpy as np
import pandas as pd

from scenarios.arrays import Floats
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.mma_metrics import NO_PAIR
from tracker.records import MODELS

NO_MODEL = "the tracks do not report the selected model"


def grade(sheet: MetricSheet, tracks: pd.DataFrame) -> None:
    """Enter the accuracy, the confusions and the switch latency from the judged rows of the track table.

    Confusions are shares of the frames of each true mode.
    """
    known = tracks["model"].notna()
    judged, no_pair = tracks[tracks["judged"] & known], NO_PAIR if known.all() else NO_MODEL
    vehicle = judged["actor_id"].to_numpy()
    true, chosen = judged["true_mode"].to_numpy(object), judged["model"].to_numpy(object)
    sheet.mean("mma.mode_accuracy", chosen == true, no_pair, vehicle)
    sheet.mean("mma.stationary_accuracy", (chosen == MODELS[0]) == (true == MODELS[0]), no_pair, vehicle)
    for mode, model in product(MODELS, MODELS):
        why = f"{no_pair} in the mode {mode}"
        sheet.mean(f"mma.confusion.{mode}.{model}", chosen[true == mode] == model, why, vehicle[true == mode])
    _grade_latency(sheet, switch_latencies(judged))


def switch_latencies(judged: pd.DataFrame) -> Floats:
    """Return the frames from each change of the true mode to its selection.

    Infinite if the mode is not selected before the next change. A change counts if the vehicle is followed in the frame
    of the change and in the previous one.
    """
    latencies: list[float] = []
    for _, rows in judged.sort_values("frame", kind="stable").groupby("actor_id"):
        frame = rows["frame"].to_numpy()
        mode, model = rows["true_mode"].cat.codes.to_numpy(), rows["model"].cat.codes.to_numpy()
        changes = np.flatnonzero(np.diff(mode)) + 1
        for start, stop in pairwise([*changes, len(mode)]):
            if frame[start] - frame[start - 1] == 1:
                agrees = start + np.flatnonzero(model[start:stop] == mode[start])
                latencies.append(float(frame[agrees[0]] - frame[start]) if len(agrees) else np.inf)
    return np.array(latencies)


def _grade_latency(sheet: MetricSheet, latencies: Floats) -> None:
    why, median = "no followed vehicle changed its mode", None
    if len(latencies):
        median = float(np.median(latencies))
    if median == np.inf:
        why, median = "half of the changes of mode or more were never selected", None
    sheet.write("mma.switch_latency_frames", median, len(latencies), why)
