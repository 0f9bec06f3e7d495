"""Pairs of runs of BASE and HEAD with the same scenario and seed, hence the same random draws of traffic and noise."""

from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.arrays import Floats
from scenarios.compare.digest import LIMITS, Key, RunDigest, differing
from scenarios.compare.sides import Side
from scenarios.errors import InputError

MAY_DIFFER = {"device": "The device under test", "tracker": "The [tracker] table", LIMITS: "The [expect] table"}
"""Sections of the configuration that may differ between BASE and HEAD, with their names in notes."""


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
    def same_truth(self) -> bool:
        """True if both trackers had the same traffic and points."""
        return self.base.truth_hash == self.head.truth_hash

    def units(self) -> tuple[Floats, Floats]:
        """Return the sums of BASE and of HEAD (U, len(COLUMNS)) of the U resampling units.

        A unit is a vehicle; `NO_ACTOR`, with the false tracks, is one more. If the truth differs, vehicles have no
        counterparts and the whole run is one unit.
        """
        base, head = self.base.vehicles.columns(), self.head.vehicles.columns()
        if self.same_truth:
            return base, head
        return base.sum(axis=0, keepdims=True), head.sum(axis=0, keepdims=True)


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
        why = "; ".join(f"{key}: {reason}" for key, reason in incomparable.items())
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
    other = [pair.key for pair in compared if not pair.same_truth]
    if other:
        notes.append(
            f"Traffic or points differ in {listed(other)}: the ego is controlled by its tracks, or the simulation has "
            "changed. Each such run counts as one unit, and its difference is not caused by the tracker alone"
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
