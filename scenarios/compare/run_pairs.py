"""Pairs of runs of BASE and HEAD with the same scenario and seed, hence the same random draws of traffic and noise."""

from collections.abc import Iterable
from dataclasses import dataclass

from luxloop.scenarios.compare.digest import LIMITS, Key, RunDigest, differing
from luxloop.scenarios.compare.run_pair import Pair
from luxloop.scenarios.compare.sides import Side
from luxloop.scenarios.errors import InputError

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
