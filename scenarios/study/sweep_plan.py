"""Runs of a sweep that have no row yet, planned while earlier ones are executed."""

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, islice
from typing import Any

from luxloop.scenarios.study import design, run_content
from luxloop.scenarios.study.design import StudyRun
from luxloop.scenarios.study.row_store import RowStore, RunRow
from luxloop.scenarios.study.study_file import Study

NEW = "new"
TAKEN_OVER = "taken over: the same scenario, files, sources and versions"
RETRIED = "run again: it ended with an error"
AGAIN = "run again: "
"""Reasons why the row of a run is taken over from an earlier start, or the run is executed."""
CHECKED_FIRST = 100
"""Combinations that are built and validated before the first run; the others are while earlier ones are executed."""

Combination = tuple[str, ...]
"""Texts of seed, tracker and values of all parameters."""


class SweepPlan:
    """Plan of a sweep: the first combinations are built at once, the others when `missing` is asked for their runs.

    Parameters
    ----------
    study
        The study.
    tracker
        MODULE:NAME of the device under test.
    rows
        Rows of earlier starts.
    retry_errors
        True to execute runs again whose row has the status `error`.

    Raises
    ------
    StudyError
        As for `design.plan`.
    """

    def __init__(self, study: Study, tracker: str, rows: RowStore, *, retry_errors: bool) -> None:
        self._parameters = [parameter.key for parameter in study.vary]
        known = ("key", "status", "inputs", "seed", "tracker", *self._parameters)
        self._earlier = [{name: row[name] for name in known} for row in rows.facts()]
        self._status = {row["key"]: row["status"] for row in self._earlier}
        self._retry_errors = retry_errors
        new, earlier = self._split(study, tracker)
        planned = design.plan(study, tracker, new + earlier)
        self._checked = list(islice(planned, CHECKED_FIRST))
        self._planned = chain.from_iterable(chain(self._checked, planned))
        self._keys: dict[int, str] = {}
        self._count = (len(new) + len(earlier)) * len(study.seed_list)
        self._new = len(new) * len(study.seed_list)
        self.taken_over: set[str] = set()
        """Keys of the planned runs whose rows are reused."""

    def _split(self, study: Study, tracker: str) -> tuple[list[int], list[int]]:
        """Return the numbers of the combinations that miss a row, and of those with rows for all seeds.

        Only the scene tells whether such rows are up to date. Those scenes are built last: the first run of a resumed
        sweep does not wait for them.
        """
        rows = (row for row in self._earlier if not self._is_retried(row["status"]))
        known = {combination(row, self._parameters) for row in rows}
        split: tuple[list[int], list[int]] = [], []
        for number, values in enumerate(design.combinations(study)):
            runs = ({"seed": seed, "tracker": tracker, **values} for seed in study.seed_list)
            split[all(combination(run, self._parameters) in known for run in runs)].append(number)
        return split

    def _is_retried(self, status: str) -> bool:
        return status == "error" and self._retry_errors

    @property
    def keys(self) -> list[str]:
        """Keys of the runs planned so far, in the order of the study."""
        checked = {run.index: run.key for of_combination in self._checked for run in of_combination}
        return [key for _, key in sorted((checked | self._keys).items())]

    @property
    def unseen(self) -> int:
        """Number of runs that are not planned yet and have a row of an earlier start, which may be out of date."""
        return self._count - max(self._new, len(self.keys))

    def missing(self) -> Iterator[StudyRun]:
        """Yield the runs without a row, once each, with the reason why they are executed.

        Runs of combinations that miss a row come first.

        Raises
        ------
        StudyError
            A combination after the first `CHECKED_FIRST` is not a valid scenario.
        """
        seen, inputs = set[str](), dict[Combination, str]()
        for run in self._planned:
            key = run.key
            self._keys[run.index] = key
            status = self._status.get(key)
            retried = status is not None and self._is_retried(status)
            if status is not None and not retried:
                self.taken_over.add(key)
            elif key not in seen:
                seen.add(key)
                inputs = inputs or {combination(row, self._parameters): row["inputs"] for row in self._earlier}
                yield run.because(RETRIED if retried else why_run(run, inputs))


def why_run(run: StudyRun, inputs: Mapping[Combination, str]) -> str:
    """Return why a run without a row is executed: it is new, or its inputs differ from those of an earlier row.

    Parameters
    ----------
    run
        The run.
    inputs
        Digests of the inputs of earlier rows, as JSON; the latest of each combination.
    """
    before = inputs.get(combination({"seed": run.seed, "tracker": run.tracker, **run.parameters}, [*run.parameters]))
    if before is None:
        return NEW
    return AGAIN + ", ".join(run_content.changes(json.loads(before or "{}"), run.inputs))


def combination(row: RunRow, parameters: Sequence[str]) -> Combination:
    """Return seed, tracker and values of the varied parameters of a row as texts, which can be compared."""
    values = (row[key] for key in ("seed", "tracker", *parameters))
    return tuple(f"{float(value):.12g}" if _is_number(value) else str(value) for value in values)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
