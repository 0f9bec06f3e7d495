"""Standings of the league: pooled figures of each tracker, and paired differences to the shipped one."""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.compare import comparison, run_pairs
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, ComparedMetric
from luxloop.scenarios.compare.comparison import Comparison
from luxloop.scenarios.compare.digest import Key, RunDigest, read_run
from luxloop.scenarios.compare.resampling import difference_interval
from luxloop.scenarios.compare.run_pairs import Side
from luxloop.scenarios.league.league_runs import RUNS, Row
from luxloop.scenarios.run import run_folder
from luxloop.scenarios.run.device import REFERENCE
from luxloop.scenarios.statistics.intervals import Interval
from luxloop.scenarios.statistics.jackknife import SHARE, jackknife_interval

GOSPA = "track.gospa_m"


@dataclass(frozen=True, slots=True)
class PairedDifference:
    """Difference of a metric to the shipped tracker, over the runs that both finished."""

    difference: float
    interval: Interval
    """95 % interval; NaN without one."""
    better: bool
    """True if the tracker is better than the shipped one."""

    @property
    def clear(self) -> bool:
        """True if the interval does not contain 0."""
        return self.interval[0] > 0.0 or self.interval[1] < 0.0


def gospa_sums(side: Side) -> dict[Key, Floats]:
    """Return sum of GOSPA [m] and number of frames of each run."""
    found: dict[Key, Floats] = {}
    for key in side.runs:
        metric = run_folder.read(side.path / f"{key.scenario}-seed{key.seed}").metrics[GOSPA]
        if metric.value is not None:
            found[key] = np.array([metric.value * metric.n, metric.n])
    return found


def mean_gospa(sums: Sequence[Floats]) -> float:
    """Return the mean over all frames of some runs [m]; NaN without one."""
    total = np.sum(sums, axis=0) if sums else np.zeros(2)
    return float(total[0] / total[1]) if total[1] else math.nan


def gospa_difference(of_base: Mapping[Key, Floats], of_head: Mapping[Key, Floats]) -> PairedDifference:
    """Return the difference of the means over frames, with an interval that leaves out one run after the other."""
    common = [key for key in of_head if key in of_base]
    base, head = [of_base[key] for key in common], [of_head[key] for key in common]
    difference = mean_gospa(head) - mean_gospa(base)
    kept = [[k for k in range(len(head)) if k != run] for run in range(len(head))]
    rest = [mean_gospa([head[k] for k in runs]) - mean_gospa([base[k] for k in runs]) for runs in kept]
    weight = np.array([float(each[1]) for each in head])
    interval = difference_interval(difference, np.array(rest), weight)
    return PairedDifference(difference, interval, difference < 0.0)


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
    gospa = {name: gospa_sums(side) for name, side in sides.items()}
    found = [_standing(name, of_tracker, sides, gospa) for name in trackers]
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


def _standing(
    name: str,
    of_tracker: Mapping[str, Sequence[Row]],
    sides: Mapping[str, Side],
    gospa: Mapping[str, Mapping[Key, Floats]],
) -> Standing:
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
        gospa_m=mean_gospa([*gospa[name].values()]),
        step_ratio=_step_ratio(finished, of_tracker[REFERENCE]),
        differences={} if comparison_to is None else _differences(comparison_to, gospa[REFERENCE], gospa[name]),
        hota_by_scenario=_by_scenario(digests),
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


def _differences(
    found: Comparison, of_base: Mapping[Key, Floats], of_head: Mapping[Key, Floats]
) -> dict[str, PairedDifference]:
    differences = {}
    for change in found.changes:
        if change.metric.name in PAIRED:
            numbers = change.numbers
            better = change.metric.loss(numbers.difference) < 0.0
            differences[change.metric.name] = PairedDifference(numbers.difference, numbers.interval, better)
    return {**differences, GOSPA: gospa_difference(of_base, of_head)}


def _step_ratio(rows: Sequence[Row], reference: Sequence[Row]) -> float:
    base = {(row["scenario"], row["seed"]): row["step_ms_p50"] for row in reference}
    ratios = [
        row["step_ms_p50"] / base[key]
        for row in rows
        if (key := (row["scenario"], row["seed"])) in base and base[key] and row["step_ms_p50"]
    ]
    return statistics.median(ratios) if ratios else math.nan
