"""Key metrics over many baselines, of all runs together and of each scenario."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.compare import run_pairs
from luxloop.scenarios.compare.compared_metrics import COMPARED_METRICS, values
from luxloop.scenarios.compare.comparison import MetricVerdict, compare
from luxloop.scenarios.compare.digest import Key, RunDigest, differing
from luxloop.scenarios.compare.sides import Side
from luxloop.scenarios.errors import InputError

TITLES = {
    "track.hota": "HOTA", "track.idf1": "IDF1", "track.missed_share": "missed", "track.false_share": "false",
    "track.id_switch_rate": "id switches", "fit.heading_abs_mean_deg": "fit heading [deg]",
}  # fmt: skip
"""Key metrics with short names."""
KEY_METRICS = tuple(metric for metric in COMPARED_METRICS if metric.name in TITLES)


@dataclass(frozen=True, slots=True, eq=False)
class Trends:
    """M key metrics over B baselines, in the order of the command line."""

    labels: list[str]
    """(B,) short names of the baselines."""
    paths: list[Path]
    common: list[Key]
    """Complete runs of all baselines, which the suite's values are pooled over."""
    suite: Floats
    """(B, M) metrics of all common runs together."""
    scenarios: dict[str, Floats]
    """(B, M) metrics of the runs of each scenario; NaN where a baseline has none."""
    changed: dict[str, list[int]]
    """Numbers of the baselines whose scenario differs from that of the baseline before, by scenario."""
    verdicts: list[dict[str, MetricVerdict]]
    """(B,) verdict of each metric against the baseline before; empty where no pair can be compared."""


def trends(sides: Sequence[Side]) -> Trends:
    """Return the trends over baselines.

    Raises
    ------
    InputError
        There are fewer than two baselines, or no complete run is in all of them.
    """
    if len(sides) < 2:
        raise InputError(f"{sides[0].path}: the only baseline; give at least two, the earliest first")
    complete = [{key: run for key, run in side.runs.items() if not run.ended_early} for side in sides]
    common = sorted(set.intersection(*(set(runs) for runs in complete)))
    if not common:
        raise InputError("no complete run is in all baselines; give baselines with the same scenarios and seeds")
    names = sorted({key.scenario for runs in complete for key in runs})
    return Trends(
        labels=labels([side.path for side in sides]),
        paths=[side.path for side in sides],
        common=common,
        suite=np.vstack([_values([runs[key] for key in common]) for runs in complete]),
        scenarios={name: np.vstack([_values(_of(name, runs.values())) for runs in complete]) for name in names},
        changed={name: found for name in names if (found := _changed([_of(name, runs.values()) for runs in complete]))},
        verdicts=[{}, *(_verdicts(before, after) for before, after in pairwise(sides))],
    )


def labels(paths: Sequence[Path]) -> list[str]:
    """Return the names of files without their endings, or the shortest ends of the paths that are all different."""
    parts = [(*path.parts[:-1], path.stem if path.suffix == ".jsonl" else path.name) for path in paths]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-length:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{number}: {'/'.join(part)}" for number, part in enumerate(parts, start=1)]


def _of(scenario: str, runs: Iterable[RunDigest]) -> list[RunDigest]:
    return [run for run in runs if run.key.scenario == scenario]


def _values(runs: list[RunDigest]) -> Floats:
    """(M,) key metrics of several runs together; NaN without a run."""
    if not runs:
        return np.full(len(KEY_METRICS), np.nan)
    sums = np.vstack([run.vehicles.columns() for run in runs]).sum(axis=0, keepdims=True)
    found: Floats = values(sums, KEY_METRICS)[0]
    return found


def _changed(runs: list[list[RunDigest]]) -> list[int]:
    """Return the numbers of the baselines in which the scenario differs from the one before."""
    found = []
    for number, (before, after) in enumerate(pairwise(runs), start=1):
        if before and after and set(differing(before[0].sections, after[0].sections)) - set(run_pairs.MAY_DIFFER):
            found.append(number)
    return found


def _verdicts(before: Side, after: Side) -> dict[str, MetricVerdict]:
    try:
        comparison = compare(run_pairs.pair(before, after))
    except InputError:  # no pair can be compared
        return {}
    return {change.metric.name: change.verdict for change in comparison.changes if change.metric.name in TITLES}
