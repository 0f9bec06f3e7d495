"""Sides of a comparison, and pairs of runs of BASE and HEAD with the same scenario and seed, hence the same draws."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.compare import baseline_file
from luxloop.scenarios.compare.digest import LIMITS, Key, RunDigest, differing, digest, read_run
from luxloop.scenarios.compare.vehicle_sums import counterparts
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import run_folder
from luxloop.sensor_model.truth import NO_ACTOR

SUMS_TOLERANCE = 2e-6
"""Relative difference of two sums that is none: another CPU and the rounding of the baseline change them by 1e-6."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two runs that can be compared."""

    base: RunDigest
    head: RunDigest

    @property
    def key(self) -> Key:
        """Scenario and seed of both runs."""
        return self.base.key

    @property
    def identical(self) -> bool:
        """True if frames, scans and tracks are bit-identical."""
        return self.base.trace_hash == self.head.trace_hash

    @property
    def same(self) -> bool:
        """True if the truth and all sums are equal within the tolerances."""
        base, head = self.units()
        return self.same_truth and bool(np.array_equal(base, head))

    @property
    def same_truth(self) -> bool:
        """True if both trackers had the same traffic and points, within the tolerances."""
        base, head = self.base.vehicles, self.head.vehicles
        return len(base.vehicle) == len(head.vehicle) == len(self._counterparts()[0])

    @property
    def without_counterpart(self) -> int:
        """Number of vehicles of BASE or HEAD, whichever has more, without a counterpart on the other side."""
        vehicles = max(len(run.vehicles.vehicle) - 1 for run in (self.base, self.head))
        return vehicles - int((self.base.vehicles.vehicle[self._counterparts()[0]] != NO_ACTOR).sum())

    def units(self) -> tuple[Floats, Floats]:
        """Return the sums of BASE and of HEAD (U, len(COLUMNS)) of the U resampling units.

        A unit is a vehicle with the same truth on both sides. The last unit is everything else: false tracks, and
        vehicles without a counterpart, because traffic or points differ. Sums of HEAD within the tolerance of those of
        BASE are set equal to them: such differences come from another CPU, not from another tracker.
        """
        base, head = self.base.vehicles.columns(), self.head.vehicles.columns()
        own, others = self._counterparts()
        paired = self.base.vehicles.vehicle[own] != NO_ACTOR
        base, head = _units(base, own[paired]), _units(head, others[paired])
        return base, np.where(np.isclose(head, base, rtol=SUMS_TOLERANCE, atol=0.0), base, head)

    def _counterparts(self) -> tuple[Ints, Ints]:
        base, head = self.base.vehicles, self.head.vehicles
        return counterparts(base.vehicle, head.vehicle, base.truth, head.truth)


def _units(columns: Floats, paired: Ints) -> Floats:
    """Return the rows of the paired vehicles and the sum of all others."""
    return np.vstack([columns[paired], np.delete(columns, paired, axis=0).sum(axis=0)])


@dataclass(frozen=True, slots=True)
class Side:
    """Runs by scenario and seed."""

    path: Path
    """Folder or file; for results, the name of the side."""
    runs: dict[Key, RunDigest]
    unfinished: list[str]
    """Names of temporary folders of unfinished runs, which are left out."""


def side_of(runs: str | Path | Result | Iterable[str | Path | Result], name: str) -> Side:
    """Return a side: a folder or file, a result, or several run folders or results, which `name` names in messages.

    Raises
    ------
    OutputError
        As for `read`.
    """
    if isinstance(runs, str | Path):
        return read_side(Path(runs))
    every = [runs] if isinstance(runs, Result) else runs
    return _side(Path(name), [_digest(run) for run in every], [])


def _digest(run: str | Path | Result) -> tuple[RunDigest, Path]:
    if isinstance(run, Result):
        return digest(run), run.out or Path("in memory")
    return read_run(Path(run)), Path(run)


def read_side(path: Path) -> Side:
    """Read BASE or HEAD.

    Raises
    ------
    OutputError
        `path` has no run, a run is damaged, or two runs have the same scenario and seed.
    """
    return read_runs(path) if path.is_dir() else _side(path, [(run, path) for run in baseline_file.read(path)], [])


def read_runs(folder: Path) -> Side:
    """Read all runs in a folder and its subfolders, or a single run folder.

    Raises
    ------
    OutputError
        As for `read`.
    """
    if not folder.is_dir():
        raise OutputError(f"{folder}: no such folder; give a folder with runs of luxloop run or pytest")
    unfinished = sorted(path.name for path in folder.rglob(".*.partial"))
    return _side(folder, [(read_run(run), run) for run in run_folder.found_in(folder)], unfinished)


def _side(path: Path, runs: list[tuple[RunDigest, Path]], unfinished: list[str]) -> Side:
    """Sort the runs, each with the path it was read from, by scenario and seed."""
    if not runs:
        raise OutputError(f"{path}: no run in it; give a folder with runs of luxloop run or pytest")
    by_key: dict[Key, RunDigest] = {}
    places: dict[Key, Path] = {}
    for run, place in sorted(runs, key=lambda entry: entry[0].key):
        if run.key in by_key:
            raise OutputError(f"{path}: two runs of {run.key}, {places[run.key]} and {place}; keep one of them")
        by_key[run.key], places[run.key] = run, place
    return Side(path, by_key, unfinished)


MAY_DIFFER = {"device": "The device under test", "tracker": "The [tracker] table", LIMITS: "The [expect] table"}
"""Sections of the configuration that may differ between BASE and HEAD, with their names in notes."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """Compared runs, and runs left out with the reason."""

    compared: list[Pair]
    only_base: list[Key]
    only_head: list[Key]
    incomparable: dict[Key, str]
    """Pairs that are not compared, with the reason."""
    newly_incomplete: list[Key]
    """Incomparable pairs that ended early in HEAD but not in BASE."""
    notes: list[str]
    """Differences of the two sides to mention in the report."""


def pair(base: Side, head: Side) -> Pairs:
    """Pair the runs of both sides.

    Raises
    ------
    InputError
        No pair can be compared.
    """
    common = [(base.runs[key], head.runs[key]) for key in base.runs if key in head.runs]
    incomparable = {b.key: why for b, h in common if (why := _why_incomparable(b, h))}
    compared = [Pair(b, h) for b, h in common if b.key not in incomparable]
    if not compared:
        reasons: dict[str, list[Key]] = {}
        for key, reason in incomparable.items():
            reasons.setdefault(reason, []).append(key)
        why = "; ".join(f"{listed(keys)}: {reason}" for reason, keys in reasons.items())
        raise InputError(
            f"{base.path} and {head.path}: nothing to compare, "
            + (why or "no scenario was run with the same seed in both; run the same scenarios with the same seeds")
        )
    return Pairs(
        compared=compared,
        only_base=[key for key in base.runs if key not in head.runs],
        only_head=[key for key in head.runs if key not in base.runs],
        incomparable=incomparable,
        newly_incomplete=[b.key for b, h in common if h.ended_early and not b.ended_early],
        notes=_notes(base, head, compared),
    )


def require_same_limits(base: Side, head: Side) -> None:
    """Check that runs of the same scenario and seed were judged by the same limits, those of times (`perf.*`) apart.

    Raises
    ------
    InputError
        The limits of a run differ. A comparison with a looser limit would hide the failure that it was loosened for.
    """
    differ = {
        key: names
        for key in base.runs
        if key in head.runs and (names := differing(_limits(base.runs[key]), _limits(head.runs[key])))
    }
    if differ:
        key, (name, *_) = next(iter(differ.items()))
        before, after = (_limits(side.runs[key]).get(name, "none") for side in (base, head))
        raise InputError(
            f"{base.path} and {head.path}: the limits of {listed(differ)} differ ({name}: {before} in BASE, {after} in "
            "HEAD); run BASE again with the limits of HEAD, or, if they were changed on purpose, make the baseline "
            f"anew: luxloop baseline {head.path} --out FILE"
        )


def _limits(run: RunDigest) -> dict[str, str]:
    return {name: expectation.limit for name, expectation in run.expectations.items()}


def _why_incomparable(base: RunDigest, head: RunDigest) -> str:
    """Return the reason why two runs cannot be compared, or an empty string."""
    differ = [key for key in differing(base.sections, head.sections) if key not in MAY_DIFFER]
    if differ:
        return f"the scenario has changed ({', '.join(differ)} differ); run BASE again with the scenario of HEAD"
    sides = {"BASE": base, "HEAD": head}
    return " and ".join(f"{name} ended early ({run.ended_early})" for name, run in sides.items() if run.ended_early)


def _notes(base: Side, head: Side, compared: list[Pair]) -> list[str]:
    """Return notes on differences other than those of the tracks."""
    notes = [f"{side.path}: left out, not finished: {name}" for side in (base, head) for name in side.unfinished]
    for key, what in MAY_DIFFER.items():
        changed = [pair.key for pair in compared if key in differing(pair.base.sections, pair.head.sections)]
        if changed:
            notes.append(f"{what} differs in {listed(changed)}")
    other = {pair.key: pair.without_counterpart for pair in compared if not pair.same_truth}
    if other:
        notes.append(
            f"Traffic or points differ in {listed(other)} ({sum(other.values())} vehicles without a counterpart): the "
            "ego is controlled by its tracks, or the simulation has changed. These vehicles count as one unit per run, "
            "and their difference is not caused by the tracker alone"
        )
    return notes + _versions(compared)


def _versions(compared: list[Pair]) -> list[str]:
    """Return notes on packages with different versions."""
    return sorted(
        {
            f"{package} is {pair.base.versions.get(package, 'missing')} in BASE and "
            f"{pair.head.versions.get(package, 'missing')} in HEAD"
            for pair in compared
            for package in differing(pair.base.versions, pair.head.versions)
        }
    )


def listed(keys: Iterable[Key], most: int = 4) -> str:
    """Return the names of the first `most` runs, and the number of the others."""
    names = [str(key) for key in keys]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
