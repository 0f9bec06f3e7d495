"""`luxloop list` and `luxloop metrics`."""

import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import AsJson

if TYPE_CHECKING:
    from luxloop.scenarios.files.shipped import Entry
    from luxloop.scenarios.metrics.definition import MetricDefinition


def list_scenarios(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[WORD]...", help="Words that name or description must contain.")
    ] = None,
    family: Annotated[str | None, typer.Option(help="Only scenarios of this family, e.g. urban.")] = None,
    kind: Annotated[
        str | None, typer.Option(help="Only scenarios with this traffic: sumo, highway-env, scripted or replay.")
    ] = None,
    suite: Annotated[str | None, typer.Option(help="Only scenarios of this suite: smoke or full.")] = None,
    folder: Annotated[bool, typer.Option("--folder", help="Print the folder of the files, for pytest.")] = False,
    studies: Annotated[bool, typer.Option("--studies", help="List the studies instead.")] = False,
    as_json: AsJson = False,
) -> None:
    """List the shipped scenarios with a one-line description each."""
    import json

    from luxloop.scenarios import interface
    from luxloop.scenarios.files import shipped

    if folder:
        print_text(str(shipped.STUDIES if studies else shipped.CATALOG))
        return
    filters = {"family": family, "kind": kind, "suite": suite}
    if studies:
        _refuse(filters)
        found = shipped.chosen(shipped.study_entries(), words or [])
    else:
        found = interface.list_scenarios(*(words or []), **filters)
    if as_json:
        print_text(json.dumps([_document(entry) for entry in found]))
    else:
        head = ("command", "name", "question") if studies else ("family", "name", "description")
        show_table(head, [entry[:3] for entry in found])


def _refuse(filters: dict[str, str | None]) -> None:
    """Raise an error for filters, which studies do not have."""
    from luxloop.scenarios.errors import InputError

    for name, value in filters.items():
        if value is not None:
            raise InputError(f"--{name} {value}: studies have none; omit --{name} or --studies")


def _document(entry: "Entry") -> dict[str, Any]:
    """Return an entry for `--json`, without what a study does not have."""
    return {name: str(value) if name == "path" else value for name, value in entry._asdict().items() if value}


def show_table(head: tuple[str, ...], lines: Sequence[tuple[str, ...]]) -> None:
    """Print a table on a terminal, and a line per row elsewhere. Names are not broken."""
    if not sys.stdout.isatty():
        widths = [max(map(len, column)) for column in zip(head, *lines, strict=True)]
        for line in (head, *lines):
            print_text("  ".join(f"{cell:{width}}" for cell, width in zip(line, widths, strict=True)).rstrip())
        return
    from luxloop.scenarios.document.document import Table
    from luxloop.scenarios.report import text

    table = Table("")
    for name in head:
        table.add_column(name, no_wrap=name == "name")
    for line in lines:
        table.add_row(*line)
    text.show(table)


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
        print_text(json.dumps([_metric_document(one) for one in found]))
        return
    lines: list[tuple[str, ...]] = []
    for one, before in zip(found, [None, *found], strict=False):
        if before and _family(one) != _family(before):
            lines.append(("",) * 5)
        keys = [*(f"{key}=" for key in one.parameters), *one.filters]
        lines.append((one.name, one.unit, one.better, one.meaning, " ".join(keys)))
    show_table(("name", "unit", "better", "meaning", "parameters= and filters"), lines)
    print_text("\n".join(["", *_choices(found), EXAMPLES]))


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


def _metric_document(one: "MetricDefinition") -> dict[str, Any]:
    """Return a metric for `--json`; a parameter without default begins with an empty value."""
    return {
        "name": one.name,
        "unit": one.unit,
        "better": one.better,
        "parameters": {key: list(values) for key, values in one.parameters.items()},
        "filters": list(one.filters),
        "meaning": one.meaning,
    }
