"""Reasons why the row of a run is taken over from an earlier start, or the run is executed."""

import json
from collections.abc import Iterable, Sequence
from typing import Any

from scenarios.study import run_content
from scenarios.study.design import StudyRun

NEW = "new"
TAKEN_OVER = "taken over: the same scenario, files, sources and versions"
RETRIED = "run again: it ended with an error"
AGAIN = "run again: "

Combination = tuple[str, ...]
"""Texts of seed, tracker and values of all parameters."""


class RowReasons:
    """Compares runs with the rows of earlier starts.

    Parameters
    ----------
    parameters
        Keys of the varied parameters.
    rows
        Earlier rows, the latest last, with `seed`, `tracker`, `inputs` and a column per parameter.
    """

    def __init__(self, parameters: Sequence[str], rows: Iterable[dict[str, Any]]) -> None:
        self._parameters = parameters
        self._inputs = {self._combination(row): row["inputs"] for row in rows}

    def why_run(self, run: StudyRun) -> str:
        """Return why a run without a row is executed: it is new, or its inputs differ from those of an earlier row."""
        before = self._inputs.get(self._combination({"seed": run.seed, "tracker": run.tracker, **run.parameters}))
        if before is None:
            return NEW
        found = run_content.changes(json.loads(before or "{}"), run.inputs)
        return AGAIN + ", ".join(found)

    def _combination(self, row: dict[str, Any]) -> Combination:
        values = (row[key] for key in ("seed", "tracker", *self._parameters))
        return tuple(f"{float(value):.12g}" if _is_number(value) else str(value) for value in values)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
