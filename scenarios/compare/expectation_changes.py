"""Expectations that fail on at least one side of a comparison."""

from dataclasses import dataclass
from typing import Literal

from luxloop.scenarios.compare.digest import Expectation, Key
from luxloop.scenarios.compare.run_pair import Pair

ExpectationFate = Literal["newly failed", "now known to fail", "still failing", "mended"]


@dataclass(frozen=True, slots=True)
class ExpectationChange:
    """An expectation that fails on at least one side."""

    key: Key
    name: str
    base: Expectation | None
    """None if BASE does not have the expectation."""
    head: Expectation
    fate: ExpectationFate


def expectation_changes(pair: Pair) -> list[ExpectationChange]:
    """Return the expectations of a run that fail on at least one side; one that is missing in BASE counts as held."""
    changes = []
    for name, head in pair.head.expectations.items():
        base = pair.base.expectations.get(name)
        fate = _fate(held=base is None or base.holds, head=head)
        if fate:
            changes.append(ExpectationChange(pair.key, name, base, head, fate))
    return changes


def _fate(held: bool, head: Expectation) -> ExpectationFate | None:
    if head.holds:
        return None if held else "mended"
    if head.outcome == "failed":
        return "newly failed" if held else "still failing"
    return "now known to fail" if held and head.outcome == "known failure" else None
