"""Coverage of the intervals of studies, by studies of few seeds drawn from the committed figures of many seeds."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.study import survival
from luxloop.scenarios.study.curves import estimate

Kind = Literal["median", "share", "seeds with any", "difference"]

FOLDER = Path(__file__).parents[1] / "seed_figures"
HEADING, POSITION = "fit.heading_abs_mean_deg", "fit.position_abs_mean_m"
COLUMNS = {
    "standing": ("range_m", HEADING, POSITION, "track.missed", "track.false", "track.hota"),
    "hidden": ("track.occlusion_survival", "track.id_switches", "track.missed", "track.false", "track.hota"),
}
"""Columns of each sweep beside the seed."""


class Population(NamedTuple):
    """Figures of all seeds at one setting."""

    name: str
    kind: Kind
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
    yield Population("`track.missed`, 32 m", "median", far["track.missed"])
    yield Population("`track.false`, 32 m", "median", far["track.false"])
    yield Population("`track.false`, 32 m", "seeds with any", far["track.false"])
    kinds: dict[str, tuple[Kind, ...]] = {
        "track.occlusion_survival": ("share",),
        "track.id_switches": ("median", "seeds with any"),
        "track.missed": ("median",),
        "track.false": ("median", "seeds with any"),
        "track.hota": ("median",),
    }
    for name, shown in kinds.items():
        for kind in shown:
            yield Population(f"`{name}`, hidden car", kind, hidden[name])


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


def survival_coverage(seeds: int, runs: int, at_s: float, draws: int) -> Coverage:
    """Return the coverage of the band of a survival curve at one time.

    Times are exponential with mean 1 s, censored between 0.5 and 3 s; half of the runs of a seed have the same one.
    """
    rng = np.random.default_rng(seeds)
    found = []
    for _ in range(draws):
        same = rng.random((runs, seeds)) < 0.5
        own = np.where(same, rng.exponential(size=seeds), rng.exponential(size=(runs, seeds)))
        limit = rng.uniform(0.5, 3.0, (runs, seeds))
        time, reached = np.minimum(own, limit).ravel(), (own <= limit).ravel()
        curve = survival.curve(time, reached, np.tile(np.arange(seeds), runs).astype(np.float64))
        k = int(np.searchsorted(curve.at, at_s, side="right")) - 1
        found.append((float(curve.low[k]), float(curve.high[k])) if k >= 0 else curve.start)
    return of_intervals(float(np.exp(-at_s)), found)


def of_intervals(truth: float, intervals: list[Interval]) -> Coverage:
    """Return the coverage of some intervals."""
    low, high = np.array(intervals).T
    inside = (low <= truth + 1e-9) & (truth - 1e-9 <= high)
    return Coverage(truth, float(inside.mean()), float(np.median(high - low)))
