"""Tables of the comparison, in Markdown."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from twin.comparison import Compared
from twin.unit import in_near_field

METHODS = ("closeness", "variance", "tlinkage", "refined", "best")
BANDS = ("below 55 % of the height", "55 to 70 %", "above 70 %")
SURE_DEG = 1.0
"""[deg] Headings are compared with labels of at most this standard deviation."""


def summary(compared: Sequence[Compared]) -> str:
    """Return the mean absolute percentage errors, and the ratio of points by height."""
    groups: dict[str, Callable[[Compared], bool]] = {
        "all": lambda _: True,
        "not in the near field": lambda one: not in_near_field(one.car),
        "and no pickups": lambda one: not in_near_field(one.car) and one.car.category != "pickup",
        "and the size seen": lambda one: (
            not in_near_field(one.car) and one.car.category != "pickup" and one.car.length_seen
        ),
    }
    rows = []
    for name, belongs in groups.items():
        members = [one for one in compared if belongs(one)]
        errors, cut_errors = (np.array(values) for values in (
            [one.percentage_error for one in members], [one.cut_percentage_error for one in members],
        ))  # fmt: skip
        rows.append(
            (
                name, len(members), *(f"{value:.1f} %" for value in (
                    mean_absolute(errors), np.median(np.abs(errors)), errors.mean(), mean_absolute(cut_errors),
                )),
            )
        )  # fmt: skip
    head = ("cars", "n", "mean absolute error", "median", "bias", "four layers")
    ratio = [
        (name, f"{np.median([one.twin_bands[k] / one.bands[k] for one in compared if one.bands[k]]):.2f}")
        for k, name in enumerate(BANDS)
    ]
    return _table(head, rows) + "\n\n" + _table(("points by height", "twin over real (median)"), ratio)


def heading_table(compared: Sequence[Compared]) -> str:
    """Return mean and median absolute heading errors by method, of cars with a well-known heading."""
    sure = [one for one in compared if one.errors and one.car.heading_sigma_deg <= SURE_DEG]
    rows = []
    for method in METHODS:
        real = [abs(one.errors[method]) for one in sure]
        twin = [abs(errors[method]) for one in sure for errors in one.twin_errors if errors]
        rows.append((method, *(f"{value:.2f}" for value in (*_mean_median(real), *_mean_median(twin)))))
    head = (f"heading error [deg], n = {len(sure)}", "mean", "median", "twin mean", "twin median")
    return _table(head, rows)


def mean_absolute(errors: Iterable[float]) -> float:
    """Return the mean of the absolute values."""
    return float(np.mean(np.abs(list(errors))))


def _mean_median(values: list[float]) -> tuple[float, float]:
    return float(np.mean(values)), float(np.median(values))


def _table(head: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)
