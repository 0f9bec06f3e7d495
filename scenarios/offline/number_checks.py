"""Checks of recorded scans and labels: damaged ones would make a tracker and the grader fail far from their cause."""

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.dataset.dataset_columns import Values
from luxloop.sensor_model.truth import NO_ACTOR

LARGEST = {"time_s": 1e11, "length_m": 200.0, "width_m": 200.0, "height_m": 200.0}
"""Absolute values by column."""
LARGEST_OTHER = 1e7
"""Absolute value in all other columns of numbers, in any unit."""
SIZES = ("length_m", "width_m", "height_m")
UNIQUE = ("frame", "actor_id")


def require_numbers(values: Values) -> None:
    """Check columns of numbers: finite and of a plausible size; sizes of vehicles are positive.

    Raises
    ------
    ValueError
        A cell is not; the message names its column.
    """
    for name, column in values.items():
        if column.dtype.kind == "f" and not np.all(np.abs(column) <= LARGEST.get(name, LARGEST_OTHER)):
            raise ValueError(f"column {name}: {_worst(column):g} is no plausible number")
    for name in SIZES:
        if name in values and not np.all(values[name] > 0.0):
            raise ValueError(f"column {name}: should be positive")


def require_actors(points: Values, labels: Values) -> None:
    """Check that every point on an actor has the label of the actor in the frame.

    Raises
    ------
    ValueError
        One has none.
    """
    on_actors = points["actor_id"][points["actor_id"] != NO_ACTOR]
    if not np.isin(on_actors, labels["actor_id"]).all():
        raise ValueError("labels.parquet: an actor with points has no label")


def require_distinct(labels: Values) -> None:
    """Check that each actor has one label in a frame.

    Raises
    ------
    ValueError
        One has two.
    """
    rows = np.column_stack([labels[name] for name in UNIQUE])
    if len(np.unique(rows, axis=0)) < len(rows):
        raise ValueError("labels.parquet: an actor has two labels in a frame")


def _worst(column: Floats) -> float:
    """Return the first number that is not finite, or else the largest."""
    wrong = column[~np.isfinite(column)]
    return float(wrong[0] if len(wrong) else column[np.argmax(np.abs(column))])
