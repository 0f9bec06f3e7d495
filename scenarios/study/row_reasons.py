"""Reasons why the row of a run is taken over from an earlier start, or the run is executed."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from luxloop.scenarios.study import run_content
from luxloop.scenarios.study.design import StudyRun

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
        self._inputs = {combination(row, parameters): row["inputs"] for row in rows}

    def why_run(self, run: StudyRun) -> str:
        """Return why a run without a row is executed: it is new, or its inputs differ from those of an earlier row."""
        known = {"seed": run.seed, "tracker": run.tracker, **run.parameters}
        before = self._inputs.get(combination(known, self._parameters))
        if before is None:
            return NEW
        found = run_content.changes(json.loads(before or "{}"), run.inputs)
        return AGAIN + ", ".join(found)


def combination(row: Mapping[str, Any], parameters: Sequence[str]) -> Combination:
    """Return seed, tracker and values of the varied parameters of a row as texts, which can be compared."""
    values = (row[key] for key in ("seed", "tracker", *parameters))
    return tuple(f"{float(value):.12g}" if _is_number(value) else str(value) for value in values)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
