"""Coverage of the intervals of a run's page and of a comparison, by runs of few vehicles drawn from many."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from intervals.populations import FOLDER
from intervals.seed_coverage import Coverage, of_intervals

from luxloop.arrays import Floats
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.resampling import difference_interval
from luxloop.scenarios.compare.run_pairs import read_side
from luxloop.scenarios.compare.vehicle_sums import COLUMNS
from luxloop.scenarios.metrics.definitions import find_metric
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import jackknife_interval

BASELINE = Path(__file__).parents[2] / "scenarios" / "baseline" / "catalog.jsonl"
PAIRED = FOLDER / "paired_vehicles.csv"
METRICS = (
    *("fit.heading_abs_mean_deg", "fit.position_abs_mean_m", "mma.y_abs_mean_m{target=moving}"),
    *("track.hota", "track.idf1", "track.mota", "track.missed_share", "track.occlusion_survival"),
)
PAIRED_METRICS = ("fit.heading_abs_mean_deg", "fit.position_abs_mean_m", "track.idf1", "track.missed_share")
BY_NAME = {metric.name: metric for metric in COMPARED_METRICS}

Rows = Iterator[tuple[str, list[Coverage]]]


def vehicle_coverage(numbers: tuple[int, ...], draws: int) -> Rows:
    """Yield a row per metric, with its coverage for runs of these numbers of vehicles."""
    population = np.vstack([run.vehicles.columns() for run in read_side(BASELINE).runs.values()])
    for name in METRICS:
        metric = BY_NAME[name]
        seen = population[metric.observations(population) > 0.0]
        yield f"`{name}`", [_coverage(seen, metric, number, draws) for number in numbers]


def _coverage(population: Floats, metric: ComparedMetric, vehicles: int, draws: int) -> Coverage:
    rng, within = np.random.default_rng(vehicles), find_metric(metric.name).definition.range
    found: list[Interval] = []
    for drawn in population[rng.integers(len(population), size=(draws, vehicles))]:
        total = drawn.sum(axis=0)
        value, weight = float(metric.value(total[None])[0]), metric.observations(drawn)
        interval = jackknife_interval(value, metric.value(total - drawn), weight, within)
        found += [interval] if interval else []
    return of_intervals(float(metric.value(population.sum(axis=0)[None])[0]), found)


def difference_coverage(numbers: tuple[int, ...], draws: int) -> Rows:
    """Yield a row per metric, with the coverage of differences between two versions for these numbers of vehicles."""
    base, head = _paired()
    for name in PAIRED_METRICS:
        metric = BY_NAME[name]
        seen = metric.observations(base) + metric.observations(head) > 0.0
        yield f"`{name}`", [_difference(base[seen], head[seen], metric, number, draws) for number in numbers]


def _difference(base: Floats, head: Floats, metric: ComparedMetric, vehicles: int, draws: int) -> Coverage:
    rng = np.random.default_rng(vehicles)
    found: list[Interval] = []
    for drawn in rng.integers(len(base), size=(draws, vehicles)):
        before, after = base[drawn], head[drawn]
        change = metric.value(after.sum(axis=0)[None]) - metric.value(before.sum(axis=0)[None])
        without = metric.value(after.sum(axis=0) - after) - metric.value(before.sum(axis=0) - before)
        weight = metric.observations(before) + metric.observations(after)
        interval = difference_interval(float(change[0]), without, weight, metric.largest_difference)
        found += [interval] if np.isfinite(interval).all() else []
    truth = metric.value(head.sum(axis=0)[None]) - metric.value(base.sum(axis=0)[None])
    return of_intervals(float(truth[0]), found)


def _paired() -> tuple[Floats, Floats]:
    """Return the sums (U, len(COLUMNS)) of vehicles in two versions of the tracker; sums not in the file are 0."""
    table, sides = pd.read_csv(PAIRED), []
    for side in ("base", "head"):
        sums = np.zeros((len(table), len(COLUMNS)))
        for column in table:
            name, _, of = column.rpartition(".")
            if of == side:
                sums[:, COLUMNS.index(name)] = table[column]
        sides.append(sums)
    return sides[0], sides[1]
