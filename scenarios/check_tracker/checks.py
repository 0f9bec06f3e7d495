"""Checks of a tracker with their remedies, and the findings of one tracker."""

from dataclasses import dataclass

from luxloop.scenarios.run.output_checks import Fault

CHECKS = {
    "accepts a TrackerConfig": "accept one argument, the scenario's [tracker] table, and share no state",
    "accepts every scan": "return the remaining tracks, also for an empty or invalid scan",
    "returns Tracks": "return Tracks or (Tracks, StepTrace), see tracker/records.py",
    "shapes and types": "give each field the shape and type documented in tracker/records.py",
    "values are finite": "omit tracks whose state is unknown",
    "codes are valid": "use ids from 0, Status, the index of a model, and corner signs of +1 and -1",
    "ids are unique": "give each track of a scan its own id",
    "dead ids are not reused": "count ids up, and never assign an id twice",
    "probabilities sum to 1": "normalise model_probability row by row; without models, use Tracks.from_boxes",
    "covariances are valid": "keep them symmetric and positive semidefinite, e.g. by P = (P + P') / 2",
    "trace matches its scan": "label each point of this scan, in its order; see StepTrace",
    "scans are not modified": "copy before modifying: the grader reads the scan after the tracker",
    "outputs are not modified": "return copies: the grader keeps every output until the end of the run",
    "deterministic": "use a seeded random generator per instance, and do not iterate over sets",
    "instances are independent": "keep state in the instance, not in its class or module",
}
"""Remedy by check, in the order of the table."""


@dataclass(frozen=True, slots=True)
class Findings:
    """Results of all checks of one tracker."""

    faults: tuple[Fault, ...]
    done: frozenset[str]
    """Checks that were executed; the others had no data."""

    def of(self, check: str) -> list[Fault]:
        """Return the faults of one check, in the order of detection."""
        return [fault for fault in self.faults if fault.check == check]

    @property
    def passed(self) -> bool:
        """True if there are no faults."""
        return not self.faults
