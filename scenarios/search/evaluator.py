"""The bench on which a search tries scenarios. What came out is kept on disk: a second start repeats no run."""

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scenarios.errors import OutputError
from scenarios.search.objective import fails
from scenarios.study import append_log
from scenarios.study.design import StudyRun
from scenarios.study.study_file import Search
from scenarios.study.worker import BROKEN, Row, carry_out

Json = dict[str, Any]

CarryOut = Callable[[list[StudyRun]], Iterable[list[Row]]]
"""Carries out runs, and gives their rows as they come."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What came out of one run."""

    key: str
    """Of the run, see `Run.key`."""
    value: float | None
    """Of the metric; None where the run did not come to its end, or the metric does not apply."""
    trace_hash: str
    error: str
    """Why there is no value: of a run that failed or ended early."""


class Bench:
    """Runs scenarios for one metric.

    Parameters
    ----------
    search
        The metric and its limit.
    path
        Where the scenarios' file would be: its folder is where paths in them start.
    tracker
        MODULE:NAME of the device under test.
    log
        File of the answers, a line of JSON each; those of an earlier start are taken up.
    carry_out
        As `engine.rows_of` with its client; one run after the other in this process, if left out.

    Raises
    ------
    OutputError
        The file cannot be read, or holds something else.
    """

    def __init__(self, search: Search, path: Path, tracker: str, log: Path, carry_out: CarryOut | None = None) -> None:
        self.search, self.path, self.tracker = search, path, tracker
        self._log, self._carry_out = log, carry_out or _here
        self._answers = _read(log)
        self.runs = 0
        """Scenarios tried so far, whether they had to be run or were known."""

    @property
    def known(self) -> int:
        """Scenarios whose answer is there."""
        return len(self._answers)

    def ask(self, document: Json) -> Answer:
        """Run a scenario, unless it has been before."""
        (answer,) = self.ask_all([document])
        return answer

    def ask_all(self, documents: list[Json]) -> list[Answer]:
        """Run scenarios side by side, but for those that have been run before; their answers in the same order."""
        runs = [
            StudyRun(self.runs + n, {}, document["seed"], document, self.path, self.tracker)
            for n, document in enumerate(documents, 1)
        ]
        self.runs += len(runs)
        new = {run.key: run for run in runs if run.key not in self._answers}
        for rows in self._carry_out(list(new.values())) if new else ():
            for row in rows:
                self._keep(self._answer(row))
        return [self._answers[run.key] for run in runs]

    def fails(self, document: Json) -> bool:
        """Whether the metric breaks its limit in a scenario."""
        return fails(self.search.limit, self.ask(document).value)

    def _answer(self, row: Row) -> Answer:
        ended = row["status"] in BROKEN
        return Answer(row["key"], None if ended else row.get(self.search.metric), row["trace_hash"], row["error"])

    def _keep(self, answer: Answer) -> None:
        self._answers[answer.key] = answer
        try:
            append_log.append(self._log, json.dumps(asdict(answer)) + "\n")
        except OSError as error:
            raise OutputError(
                f"{self._log}: cannot write there ({error.strerror}); what is done is kept: make room, start again"
            ) from error


def _here(runs: list[StudyRun]) -> Iterable[list[Row]]:
    for run in runs:
        yield [carry_out(run)]


def _read(log: Path) -> dict[str, Answer]:
    """Read the answers; a last line that a kill cut short is dropped."""
    try:
        log.parent.mkdir(parents=True, exist_ok=True)
        append_log.forget_a_torn_line(log)
        lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
        answers = [Answer(**json.loads(line)) for line in lines]
    except OSError as error:
        raise OutputError(f"{log}: {error.strerror}; choose another folder with --out") from error
    except (ValueError, TypeError) as error:
        raise OutputError(f"{log}: holds no answers of a search; choose a new folder with --out") from error
    return {answer.key: answer for answer in answers}
