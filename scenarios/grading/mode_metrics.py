"""Which model is selected, held against how the vehicle truly moves."""

from itertools import pairwise, product

import numpy as np
import pandas as pd

from scenarios.arrays import Floats
from scenarios.grading.metric_sheet import MetricSheet
from scenarios.grading.mma_metrics import NO_PAIR
from tracker.records import MODELS

NOT_TOLD = "the tracks do not tell which model was selected"


def grade(sheet: MetricSheet, tracks: pd.DataFrame) -> None:
    """Enter how often the right mode is selected, which one for which, and how soon, from the judged rows.

    The confusions are rates of each true mode's frames.
    """
    told = tracks["model"].notna()
    judged, no_pair = tracks[tracks["judged"] & told], NO_PAIR if told.all() else NOT_TOLD
    vehicle = judged["actor_id"].to_numpy()
    true, chosen = judged["true_mode"].to_numpy(object), judged["model"].to_numpy(object)
    sheet.mean("mma.mode_accuracy", chosen == true, no_pair, vehicle)
    sheet.mean("mma.stationary_accuracy", (chosen == MODELS[0]) == (true == MODELS[0]), no_pair, vehicle)
    for mode, model in product(MODELS, MODELS):
        why = f"{no_pair} in the mode {mode}"
        sheet.mean(f"mma.confusion.{mode}.{model}", chosen[true == mode] == model, why, vehicle[true == mode])
    _grade_latency(sheet, switch_latencies(judged))


def switch_latencies(judged: pd.DataFrame) -> Floats:
    """Frames from each true change of mode to its selection; infinite where it is not selected before the next.

    A change counts if the vehicle is followed in the frame of the change and in the one before.
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
        why, median = "half of the changes of mode or more were never followed", None
    sheet.write("mma.switch_latency_frames", median, len(latencies), why)
