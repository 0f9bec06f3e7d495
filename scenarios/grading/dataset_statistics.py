"""Summary of the graded data set, as the paper's table I. It does not depend on the tracker."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.metric_sheet import MetricSheet
from luxloop.scenarios.grading.track_metric_names import SEEN

NO_FRAME = "there was no frame"
NO_OBSERVATION = "no vehicle was graded"


def grade(sheet: MetricSheet, observations: pd.DataFrame, frames: int) -> None:
    """Enter every `dataset` metric.

    Parameters
    ----------
    observations
        Graded rows of the truth table; an observation is a vehicle in a frame.
    frames
        Number of graded frames.
    """
    count, vehicles = len(observations), int(observations["actor_id"].nunique())
    for name, value in (("vehicles", vehicles), ("observations", count), ("frames", frames)):
        sheet.write(f"dataset.{name}", value, frames, NO_FRAME)
    sheet.rate("dataset.observations_per_vehicle", count, vehicles, NO_OBSERVATION)
    sheet.rate("dataset.observations_per_frame", count, frames, NO_FRAME)
    sheet.mean("dataset.points_per_observation", observations["points"].to_numpy(np.float64), NO_OBSERVATION)
    for view in SEEN:
        of_view = int(np.count_nonzero(observations["view"] == view))
        sheet.write(f"dataset.{view}.observations", of_view, frames, NO_FRAME)
        sheet.rate(f"dataset.{view}.share", of_view, count, NO_OBSERVATION)
