"""Answer of a run: its verdict, and how many expectations hold."""

from collections.abc import Sequence

from luxloop.scenarios.document.document import Answer
from luxloop.scenarios.document.words import Span, Style
from luxloop.scenarios.files.expect import Check, ExpectationOutcome, RunVerdict, verdict
from luxloop.scenarios.report.cells import counted
from luxloop.scenarios.result import Result

STYLES: dict[RunVerdict, Style] = {"passed": "good", "failed": "bad", "incomplete": "warn", "no limits": "info"}
OUTCOMES: dict[ExpectationOutcome, Style] = {
    "passed": "good",
    "failed": "bad",
    "known failure": "warn",
    "unexpected pass": "info",
    "not applicable": "dim",
}
NOTHING_EXPECTED = "nothing in [expect] to pass or fail"


def answer(result: Result, checks: Sequence[Check]) -> Answer:
    """Return the verdict with its sentence."""
    found = verdict(checks, result.complete)
    said = _held(checks)
    sentence = said if result.complete else f"ended early: {result.ended_early}; so far {said}"
    return Answer(sentence, found, STYLES[found])


def run_badge(found: RunVerdict) -> Span:
    """Return the verdict on a run as a badge."""
    return Span(found, STYLES[found], badge=True)


def badge(outcome: ExpectationOutcome) -> Span:
    """Return the outcome of an expectation as a badge."""
    return Span(outcome, OUTCOMES[outcome], badge=True)


def _held(checks: Sequence[Check]) -> str:
    if not checks:
        return NOTHING_EXPECTED
    count = {outcome: sum(check.outcome == outcome for check in checks) for outcome in OUTCOMES}
    said = f"{sum(check.holds for check in checks)} of {len(checks)} expectations hold"
    said += f", {count['failed']} failed" if count["failed"] else ""
    said += f", {counted(count['known failure'], 'known failure')}" if count["known failure"] else ""
    return said + (f", {count['not applicable']} not applicable" if count["not applicable"] else "")
