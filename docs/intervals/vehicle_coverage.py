"""Coverage of the intervals of a run's page and of a comparison, by runs of few vehicles drawn from many."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from blocks.stamps import BASELINE
from intervals.seed_coverage import FOLDER, Coverage, of_intervals

from luxloop.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.resampling import difference_interval
from luxloop.scenarios.compare.run_pairs import read_side
from luxloop.scenarios.compare.vehicle_sums import COLUMNS
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import jackknife_interval

ERRORS = ("fit.heading_abs_mean_deg", "fit.position_abs_mean_m")
METRICS = {
    "vehicles": (
        *(*ERRORS, "mma.y_abs_mean_m{target=moving}", "track.hota", "track.idf1", "track.mota"),
        *("track.missed_share", "track.occlusion_survival"),
    ),
    "differences": (*ERRORS, "track.idf1", "track.missed_share"),
}
"""Metrics of each table."""
BY_NAME = {metric.name: metric for metric in COMPARED_METRICS}


def vehicle_coverage(table: str, numbers: tuple[int, ...], draws: int) -> Iterator[tuple[str, list[Coverage]]]:
    """Yield a row per metric: the coverage for runs of these numbers of vehicles, or for differences between two."""
    sides = versions(table)
    for name in METRICS[table]:
        metric = BY_NAME[name]
        seen = sum(metric.observations(side) for side in sides) > 0.0
        yield f"`{name}`", [coverage([side[seen] for side in sides], metric, number, draws) for number in numbers]


def versions(table: str) -> list[Floats]:
    """Return the sums (V, len(COLUMNS)) of the baseline's vehicles, or of the same vehicles in two versions."""
    if table == "vehicles":
        return [np.vstack([run.vehicles.columns() for run in read_side(BASELINE).runs.values()])]
    file = pd.read_csv(FOLDER / "paired_vehicles.csv")
    columns = ([f"{name}.{side}" for name in COLUMNS] for side in ("base", "head"))
    return [file.reindex(columns=names, fill_value=0.0).to_numpy(np.float64) for names in columns]


def coverage(sides: Sequence[Floats], metric: ComparedMetric, vehicles: int, draws: int) -> Coverage:
    """Return the coverage of a metric's interval for samples of some vehicles."""
    rng, within = np.random.default_rng(vehicles), find_metric(metric.name).definition.range
    found: list[Interval] = []
    for rows in rng.integers(len(sides[0]), size=(draws, vehicles)):
        drawn = [side[rows] for side in sides]
        weight = np.sum([metric.observations(side) for side in drawn], axis=0)
        without = figure(metric, [side.sum(axis=0) - side for side in drawn])
        value = float(figure(metric, [side.sum(axis=0)[None] for side in drawn])[0])
        if len(sides) == 1:
            interval = jackknife_interval(value, without, weight, within)
        else:
            interval = difference_interval(value, without, weight, metric.largest_difference)
        found += [interval] if interval and np.isfinite(interval).all() else []
    return of_intervals(float(figure(metric, [side.sum(axis=0)[None] for side in sides])[0]), found)


def figure(metric: ComparedMetric, sums: Sequence[Floats]) -> Floats:
    """Return the figures of sums (N, len(COLUMNS)) of one version, or the differences between two."""
    first, *others = (metric.value(side) for side in sums)
    return others[0] - first if others else first
