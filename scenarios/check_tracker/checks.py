"""What is checked of a tracker, what to do where it fails, and what was found."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

CHECKS = {
    "is made from a TrackerConfig": "let it take one argument, the scenario's [tracker] table, and share no state",
    "takes every scan": "answer with the tracks that are left, however odd the scan",
    "returns Tracks": "return Tracks or (Tracks, StepTrace), see tracker/records.py",
    "shapes and types": "give each field the shape and type that tracker/records.py states",
    "values are finite": "report no track whose state is not known",
    "codes are known": "use Status, a model's number, and corners of +1 and -1",
    "ids are unique": "give each track of a scan its own id",
    "dead ids stay dead": "count ids up, and never give one out again",
    "probabilities sum to 1": "normalise model_probability row by row; without models, put a 1 at one of them",
    "covariances are sound": "keep them symmetric and positive semidefinite, as by P = (P + P') / 2",
    "the trace fits its scan": "label each point of this scan, in its order; see StepTrace",
    "scans are left alone": "copy what is changed: the grader reads the scan after the tracker",
    "answers are left alone": "return copies: the grader keeps every answer until the end of the run",
    "same scans, same answers": "draw from a seeded generator of its own, and iterate over no sets",
    "instances are independent": "keep state in the instance, not in its class or module",
}
"""Remedy by check, in the order in which they are shown."""


class Fault(NamedTuple):
    """One check failed."""

    check: str
    what: str
    where: str = ""
    """In which drive and scan."""


Faults = Iterator[Fault]


@dataclass(frozen=True, slots=True)
class Findings:
    """What was found of one tracker."""

    faults: tuple[Fault, ...]
    done: frozenset[str]
    """Checks that there was something to check for."""

    def of(self, check: str) -> list[Fault]:
        """Faults of one check, as found."""
        return [fault for fault in self.faults if fault.check == check]

    @property
    def passed(self) -> bool:
        """Whether there are none."""
        return not self.faults
