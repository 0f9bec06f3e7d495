"""Draft of a scenario that was run and graded by its own limits."""

from dataclasses import dataclass, replace
from pathlib import Path

from luxloop.scenarios.authoring.draft import Draft
from luxloop.scenarios.authoring.rehearsal import Rehearsal
from luxloop.scenarios.files.expect import Check, check
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.report.cells import value_of
from luxloop.scenarios.run import device, loop


@dataclass(frozen=True, slots=True)
class GradedDraft:
    """Draft with the limits that fail in its run."""

    draft: Draft
    """With its final duration, and a sentence on the check."""
    failed: list[str]
    """Limits that fail, with metric, value and limit; also an early end."""


def grade(draft: Draft, rehearsal: Rehearsal, out: Path) -> GradedDraft:
    """Run a draft with the shipped tracker, as long as its traffic lasts, and grade it as `luxloop run` does.

    Raises
    ------
    TrafficError
        The traffic cannot start, or fails.
    """
    draft = draft if rehearsal.complete else replace(draft, duration_s=rehearsal.duration_s)
    scenario = Scenario.of(draft.document(), out)
    result = loop.run(scenario, device.load(device.SHIPPED))
    checks = check(result.metrics, scenario.expect, result.config["device"])
    failed = [_line(each) for each in checks if each.outcome == "failed"]
    if not result.complete:
        failed.append(f"its duration ({result.ended_early})")
    return GradedDraft(replace(draft, choices=[*draft.choices, _sentence(draft, rehearsal, checks)]), failed)


def _line(failed: Check) -> str:
    value = failed.metric.value
    shown = value_of(failed.metric) if value is None else f"{value:.4g}"  # three digits may equal the limit
    return f"{failed.name} = {shown}, limit {failed.limit}"


def _sentence(draft: Draft, rehearsal: Rehearsal, checks: list[Check]) -> str:
    """Return the sentence on the check of a draft whose limits hold."""
    values = ", ".join(f"{each.name} {value_of(each.metric)}" for each in checks)
    short = "" if rehearsal.complete else f" It is shorter than asked for, since {rehearsal.end.rstrip('.')}."
    return (
        f"Checked by a run of the shipped tracker: {draft.duration_s:g} s with {rehearsal.near:.1f} vehicles in the "
        f"range of grading on average; all limits hold ({values}).{short}"
    )
