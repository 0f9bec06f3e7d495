"""Coverage of the intervals of studies, by studies of few seeds drawn from the committed figures of many seeds."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.study.curves import estimate

FOLDER = Path(__file__).parents[1] / "seed_figures"
HEADING, POSITION = "fit.heading_abs_mean_deg", "fit.position_abs_mean_m"
COLUMNS = {
    "standing": ("range_m", HEADING, POSITION, "track.missed", "track.false", "track.hota"),
    "hidden": ("track.occlusion_survival", "track.id_switches", "track.missed", "track.false", "track.hota"),
}
"""Columns of each sweep beside the seed."""
KINDS = {
    "32 m": {"track.missed": ("median",), "track.false": ("median", "seeds with any")},
    "hidden car": {
        "track.occlusion_survival": ("share",),
        "track.id_switches": ("median", "seeds with any"),
        "track.missed": ("median",),
        "track.false": ("median", "seeds with any"),
        "track.hota": ("median",),
    },
}
"""Kinds of figures by setting and metric; the others are medians at both ranges and their differences."""


class Population(NamedTuple):
    """Figures of all seeds at one setting."""

    name: str
    kind: str
    """`median`, `share`, `seeds with any` or `difference`."""
    values: "pd.Series[float]"
    """By seed; NaN for a seed without a value."""


class Coverage(NamedTuple):
    """Share of the drawn samples whose interval contains the truth."""

    truth: float
    share: float
    width: float
    """Median width of the intervals."""


def collect(sweeps: Path) -> None:
    """Write the CSV files from the folders `standing` and `hidden` of sweeps, with four significant digits."""
    for sweep, columns in COLUMNS.items():
        rows = pd.read_parquet(sweeps / sweep / "runs.parquet")
        rows[["seed", *columns]].to_csv(FOLDER / f"{sweep}.csv", index=False, float_format="%.4g")


def populations() -> Iterator[Population]:
    """Yield the populations of the table: a standing car at two ranges, the difference, and a hidden car."""
    standing, hidden = (pd.read_csv(FOLDER / f"{sweep}.csv").set_index("seed") for sweep in COLUMNS)
    near, far = (standing[standing["range_m"] == at] for at in (15.0, 32.0))
    for name in (HEADING, POSITION, "track.hota"):
        yield Population(f"`{name}`, 15 m", "median", near[name])
        yield Population(f"`{name}`, 32 m", "median", far[name])
    for name in (HEADING, POSITION, "track.hota", "track.missed", "track.false"):
        yield Population(f"`{name}`, 32 m minus 15 m", "difference", far[name] - near[name])
    for (setting, metrics), figures in zip(KINDS.items(), (far, hidden), strict=True):
        for name, kinds in metrics.items():
            yield from (Population(f"`{name}`, {setting}", kind, figures[name]) for kind in kinds)


def seed_coverage(population: Population, seeds: int, draws: int) -> Coverage:
    """Return the coverage of the interval for studies of some seeds, drawn with replacement."""
    values, kind = population.values.dropna().to_numpy(np.float64), population.kind
    within = (0.0, 1.0) if kind == "share" else None
    drawn = np.random.default_rng(seeds).choice(values, size=(draws, seeds))
    found = [estimate(sample, np.arange(seeds), within) for sample in drawn]
    if kind == "seeds with any":
        return of_intervals(float((values != 0.0).mean()), [(one.any_low, one.any_high) for one in found])
    truth = values.mean() if kind == "share" else np.median(values)
    return of_intervals(float(truth), [(one.low, one.high) for one in found])


def of_intervals(truth: float, intervals: list[Interval]) -> Coverage:
    """Return the coverage of some intervals."""
    low, high = np.array(intervals).T
    inside = (low <= truth + 1e-9) & (truth - 1e-9 <= high)
    return Coverage(truth, float(inside.mean()), float(np.median(high - low)))
