"""Runs of a sweep that have no row yet, planned while earlier ones are executed."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, islice

from scenarios.study import design
from scenarios.study.design import StudyRun
from scenarios.study.row_reasons import RETRIED, RowReasons
from scenarios.study.row_store import RowStore
from scenarios.study.study_file import Study

CHECKED_FIRST = 100
"""Combinations that are built and validated before the first run; the others are while earlier ones are executed."""


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
        self._status = {key: row["status"] for key, row in rows.earlier.items()}
        self._parameters = [parameter.key for parameter in study.vary]
        self._rows = rows
        self._retry_errors = retry_errors
        planned = design.plan(study, tracker)
        self._checked = list(islice(planned, CHECKED_FIRST))
        self._planned = chain.from_iterable(chain(self._checked, planned))
        self._keys: list[str] = []
        self.taken_over: set[str] = set()
        """Keys of the planned runs whose rows are reused."""

    @property
    def keys(self) -> list[str]:
        """Keys of the runs planned so far, in the order of the study."""
        checked = [run.key for of_combination in self._checked for run in of_combination]
        return self._keys + checked[len(self._keys) :]

    def missing(self) -> Iterator[StudyRun]:
        """Yield the runs without a row, once each, with the reason why they are executed.

        Raises
        ------
        StudyError
            A combination after the first `CHECKED_FIRST` is not a valid scenario.
        """
        seen, reasons = set[str](), None
        for run in self._planned:
            key = run.key
            self._keys.append(key)
            status = self._status.get(key)
            failed = status == "error" and self._retry_errors
            if status is not None and not failed:
                self.taken_over.add(key)
            elif key not in seen:
                seen.add(key)
                reasons = reasons or RowReasons(self._parameters, self._rows.earlier.values())
                yield replace(run, why=RETRIED if failed else reasons.why_run(run))
