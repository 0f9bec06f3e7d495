"""`luxloop metrics`."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from luxloop.scenarios.commands.arguments import AsJson
from luxloop.scenarios.commands.list_scenarios import show_table

if TYPE_CHECKING:
    from luxloop.scenarios.metrics.definition import MetricDefinition

EXAMPLES = """\
Filters: class=truck|bus  view=side  actor=NAME  range=0-30 [m]  points=100-  time=2-8 [s]
A name with both: fit.iou_mean{method=area,view=side}"""
"""Every filter, and a name."""


def metrics(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[WORD]...", help="Words that name or sentence must contain.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the metrics with their units, directions, parameters and filters."""
    import json

    from luxloop.scenarios.metrics.definitions import DEFINITIONS

    found = [one for one in DEFINITIONS.values() if _has(one, words or [])]
    if as_json:
        print(json.dumps([_document(one) for one in found]))
        return
    lines: list[tuple[str, ...]] = []
    for one, before in zip(found, [None, *found], strict=False):
        if before and _family(one) != _family(before):
            lines.append(("",) * 5)
        keys = [*(f"{key}=" for key in one.parameters), *one.filters]
        lines.append((one.name, one.unit, one.better, one.meaning, " ".join(keys)))
    show_table(("name", "unit", "better", "meaning", "parameters= and filters"), lines)
    print("\n".join(["", *_choices(found), EXAMPLES]))


def _has(one: "MetricDefinition", words: Iterable[str]) -> bool:
    text = f"{one.name} {one.meaning}".casefold()
    return all(word.casefold() in text for word in words)


def _family(one: "MetricDefinition") -> str:
    return one.name.partition(".")[0]


def _choices(found: "Iterable[MetricDefinition]") -> list[str]:
    """Return a line for the values of each parameter; the first is the default, unless it must be given."""
    values: dict[str, dict[str, None]] = {}
    for one in found:
        for key, choices in one.parameters.items():
            named = [choice if k else f"{choice} (default)" for k, choice in enumerate(choices) if choice]
            values.setdefault(key, {}).update(dict.fromkeys(named))
    return [f"{key}= {', '.join(choices)}" for key, choices in values.items()]


def _document(one: "MetricDefinition") -> dict[str, Any]:
    """Return a metric for `--json`; a parameter without default begins with an empty value."""
    return {
        "name": one.name,
        "unit": one.unit,
        "better": one.better,
        "parameters": {key: list(values) for key, values in one.parameters.items()},
        "filters": list(one.filters),
        "meaning": one.meaning,
    }
