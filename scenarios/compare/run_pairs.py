"""Runs of BASE and HEAD in pairs: the same scenario and seed, so that traffic and noise are the same draws."""

from collections.abc import Iterable
from dataclasses import dataclass

from scenarios.arrays import Floats
from scenarios.compare.digest import LIMITS, Key, RunDigest, differing
from scenarios.compare.sides import Side
from scenarios.errors import InputError

SAID = {"device": "The device under test", "tracker": "The [tracker] table", LIMITS: "The [expect] table"}
"""What may differ between BASE and HEAD, and is told."""


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Two runs that can be compared."""

    base: RunDigest
    head: RunDigest

    @property
    def key(self) -> Key:
        """What both ran."""
        return self.base.key

    @property
    def identical(self) -> bool:
        """Whether frames, scans and tracks are the same bit by bit."""
        return self.base.trace_hash == self.head.trace_hash

    @property
    def same_truth(self) -> bool:
        """Whether both trackers were given the same."""
        return self.base.truth_hash == self.head.truth_hash

    def units(self) -> tuple[Floats, Floats]:
        """(U, len(COLUMNS)) sums of BASE's and HEAD's, row by row of what is resampled together.

        That is a vehicle, or nobody, where false tracks belong. Where the truth differs, the vehicles are not the same
        and the whole run is one unit.
        """
        base, head = self.base.vehicles.columns(), self.head.vehicles.columns()
        if self.same_truth:
            return base, head
        return base.sum(axis=0, keepdims=True), head.sum(axis=0, keepdims=True)


@dataclass(frozen=True, slots=True)
class Pairs:
    """What can be compared, and what cannot, with the reason."""

    compared: list[Pair]
    only_base: list[Key]
    only_head: list[Key]
    unlike: dict[Key, str]
    """Pairs that are not compared, and why."""
    newly_incomplete: list[Key]
    """Those among them that ended early in HEAD, not in BASE."""
    notes: list[str]
    """What else there is to know, in words."""


def pair(base: Side, head: Side) -> Pairs:
    """Pair the runs of both sides.

    Raises
    ------
    InputError
        There is not one pair that can be compared.
    """
    common = [(base.runs[key], head.runs[key]) for key in base.runs if key in head.runs]
    unlike = {b.key: why for b, h in common if (why := _unlike(b, h))}
    compared = [Pair(b, h) for b, h in common if b.key not in unlike]
    if not compared:
        why = "; ".join(f"{key}: {reason}" for key, reason in unlike.items())
        raise InputError(
            f"{base.path} and {head.path}: nothing to compare, "
            + (why or "no scenario was run with the same seed in both; run the same scenarios with the same seeds")
        )
    return Pairs(
        compared=compared,
        only_base=[key for key in base.runs if key not in head.runs],
        only_head=[key for key in head.runs if key not in base.runs],
        unlike=unlike,
        newly_incomplete=[b.key for b, h in common if h.ended_early and not b.ended_early],
        notes=_notes(base, head, compared),
    )


def _unlike(base: RunDigest, head: RunDigest) -> str:
    """Why two runs cannot be compared; empty if they can."""
    differ = [key for key in differing(base.sections, head.sections) if key not in SAID]
    if differ:
        return f"the scenario is another one ({', '.join(differ)} differ); run BASE again with it"
    sides = {"BASE": base, "HEAD": head}
    return " and ".join(f"{name} ended early ({run.ended_early})" for name, run in sides.items() if run.ended_early)


def _notes(base: Side, head: Side, compared: list[Pair]) -> list[str]:
    """Say what differs beside the tracks."""
    notes = [f"{side.path}: left out, not finished: {name}" for side in (base, head) for name in side.unfinished]
    for key, what in SAID.items():
        changed = [pair.key for pair in compared if key in differing(pair.base.sections, pair.head.sections)]
        if changed:
            notes.append(f"{what} differs in {listed(changed)}")
    other = [pair.key for pair in compared if not pair.same_truth]
    if other:
        notes.append(
            f"Traffic or points differ in {listed(other)}: the ego follows its tracks, or what simulates has changed. "
            "Each such run counts as one unit, and its difference is not the tracker's alone"
        )
    return notes + _versions(compared)


def _versions(compared: list[Pair]) -> list[str]:
    """Say which versions changed."""
    return sorted(
        {
            f"{package} is {pair.base.versions.get(package, 'missing')} in BASE and "
            f"{pair.head.versions.get(package, 'missing')} in HEAD"
            for pair in compared
            for package in differing(pair.base.versions, pair.head.versions)
        }
    )


def listed(keys: Iterable[Key], most: int = 4) -> str:
    """Name runs, the first few of them."""
    names = [str(key) for key in keys]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
