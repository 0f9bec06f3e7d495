"""Standings of the league: pooled figures of each tracker, and paired differences to the shipped one."""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from luxloop.scenarios.compare import comparison, run_pairs
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.comparison import Comparison
from luxloop.scenarios.compare.digest import RunDigest, read_run
from luxloop.scenarios.compare.sides import Side
from luxloop.scenarios.league.gospa_difference import GOSPA, PairedDifference, gospa_difference, gospa_sums, mean_gospa
from luxloop.scenarios.league.league_runs import RUNS, Row
from luxloop.scenarios.run.device import REFERENCE
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import SHARE, jackknife_interval

HOTA: ComparedMetric = next(metric for metric in COMPARED_METRICS if metric.name == "track.hota")
PAIRED = ("track.hota", "track.id_switch_rate", "track.false_share", "track.missed_share")
"""Compared metrics of the standings."""
NO_INTERVAL = (math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class Standing:
    """Figures of a tracker over all of its finished runs."""

    tracker: str
    runs: int
    """Number of its finished runs."""
    failed: int
    hota: float
    hota_interval: Interval
    counts: dict[str, int]
    """Sums over its runs: `id_switches`, `false`, `missed`."""
    gospa_m: float
    step_ratio: float
    """Median over the runs of its median step time, as a multiple of the shipped tracker's in the same run."""
    differences: dict[str, PairedDifference]
    """By metric of `PAIRED` and `GOSPA`; empty for the shipped tracker."""
    hota_by_scenario: dict[str, float]
    comparison: Comparison | None
    """To the shipped tracker; None for itself, and without a common run."""


def standings(rows: Sequence[Row], out: Path) -> list[Standing]:
    """Return the trackers, the highest HOTA first; those without a finished run last.

    Raises
    ------
    OutputError
        A folder of a run is missing or damaged.
    """
    trackers = list(dict.fromkeys(row["tracker"] for row in rows))
    of_tracker = {name: [row for row in rows if row["tracker"] == name] for name in trackers}
    sides = {name: _side(found, out / RUNS / name) for name, found in of_tracker.items()}
    found = [_standing(name, of_tracker, sides) for name in trackers]
    return sorted(found, key=lambda each: -each.hota if math.isfinite(each.hota) else math.inf)


def ahead(found: Sequence[Standing]) -> dict[str, list[Standing]]:
    """Return the trackers with a better value than the shipped one, by metric; metrics without one are left out."""
    better = {
        metric: [each for each in found if metric in each.differences and each.differences[metric].better]
        for metric in (*PAIRED, GOSPA)
    }
    return {metric: trackers for metric, trackers in better.items() if trackers}


def beaten_in(found: Sequence[Standing]) -> dict[str, Standing]:
    """Return the scenarios in which another tracker has the highest HOTA, with that tracker."""
    shipped = next(each for each in found if each.tracker == REFERENCE)
    best = {
        scenario: max(found, key=lambda each: each.hota_by_scenario.get(scenario, -1.0))
        for scenario in shipped.hota_by_scenario
    }
    return {
        scenario: each
        for scenario, each in best.items()
        if each.hota_by_scenario[scenario] > shipped.hota_by_scenario[scenario]
    }


def _side(rows: Sequence[Row], folder: Path) -> Side:
    names = [f"{row['scenario']}-seed{row['seed']}" for row in rows if row["status"] == "finished"]
    digests = [read_run(folder / name) for name in names]
    return Side(folder, {digest.key: digest for digest in digests}, [])


def _standing(name: str, of_tracker: Mapping[str, Sequence[Row]], sides: Mapping[str, Side]) -> Standing:
    rows, digests = of_tracker[name], [*sides[name].runs.values()]
    finished = [row for row in rows if row["status"] == "finished"]
    hota, interval = pooled_hota(digests)
    comparison_to = _comparison(sides, name)
    return Standing(
        tracker=name,
        runs=len(finished),
        failed=sum(row["status"] == "failed" for row in rows),
        hota=hota,
        hota_interval=interval,
        counts={key: int(sum(row[key] or 0 for row in finished)) for key in ("id_switches", "false", "missed")},
        gospa_m=mean_gospa([*gospa_sums(sides[name]).values()]),
        step_ratio=_step_ratio(finished, of_tracker[REFERENCE]),
        differences={} if comparison_to is None else _differences(comparison_to, sides, name),
        hota_by_scenario=_by_scenario(digests),
        comparison=comparison_to,
    )


def pooled_hota(runs: Sequence[RunDigest]) -> tuple[float, Interval]:
    """Return HOTA over all vehicles of some runs, with the jackknife interval over vehicles."""
    if not runs:
        return math.nan, NO_INTERVAL
    units = np.vstack([run.vehicles.columns() for run in runs])
    total = units.sum(axis=0)
    value = float(HOTA.value(total[None])[0])
    interval = jackknife_interval(value, HOTA.value(total - units), HOTA.observations(units), SHARE)
    return value, interval or NO_INTERVAL


def _by_scenario(runs: Sequence[RunDigest]) -> dict[str, float]:
    names = sorted({run.key.scenario for run in runs})
    return {name: pooled_hota([run for run in runs if run.key.scenario == name])[0] for name in names}


def _comparison(sides: Mapping[str, Side], name: str) -> Comparison | None:
    base, head = sides[REFERENCE], sides[name]
    if name == REFERENCE or not base.runs.keys() & head.runs.keys():
        return None
    return comparison.compare(run_pairs.pair(base, head))


def _differences(found: Comparison, sides: Mapping[str, Side], name: str) -> dict[str, PairedDifference]:
    differences = {}
    for change in found.changes:
        if change.metric.name in PAIRED:
            numbers = change.numbers
            better = change.metric.loss(numbers.difference) < 0.0
            differences[change.metric.name] = PairedDifference(numbers.difference, numbers.interval, better)
    return {**differences, GOSPA: gospa_difference(gospa_sums(sides[REFERENCE]), gospa_sums(sides[name]))}


def _step_ratio(rows: Sequence[Row], reference: Sequence[Row]) -> float:
    base = {(row["scenario"], row["seed"]): row["step_ms_p50"] for row in reference}
    ratios = [
        row["step_ms_p50"] / base[key]
        for row in rows
        if (key := (row["scenario"], row["seed"])) in base and base[key] and row["step_ms_p50"]
    ]
    return statistics.median(ratios) if ratios else math.nan
