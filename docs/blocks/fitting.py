"""Table of the fits to labelled vehicles, real and simulated, from `luxloop fits`."""

from typing import Any

from blocks import commands, realism
from blocks.markdown import markdown

from luxloop.scenarios.realism import fit_observations, fit_report

SOURCES = {"street bumper": "real, bumper", "street roof": "real, roof", "simulated": "simulated"}
"""Heads of the columns, by the names of `luxloop fits`."""
DRIVES = ("sumo-crossing", "paper-campus")
VIEWS = ("flank over 2.5 m", "end and short flank", "end on", "glass or roof only")
FEWEST = 10
"""Clusters of a view that is shown."""

Json = dict[str, Any]


def table(_name: str) -> str:
    """Return errors by method and view, and the coverage of the stated deviation."""
    folders = [commands.real("street"), *map(realism.simulated, DRIVES)]
    return table_of(fit_report.document(fit_observations.of_folders(folders)).data["sources"])


def table_of(sources: Json) -> str:
    """Return the table of what `luxloop fits --json` prints."""
    columns = [sources[name] for name in SOURCES]
    names = ["clusters / vehicles", *columns[0]["error_deg"], "best minus alignment", "best minus tlinkage"]
    names += [f"best, {view}" for view in VIEWS]
    rows = [(name, *(cell(column, name) for column in columns)) for name in names]
    within = (" / ".join(f"{value:.0f}" for value, _ in column["coverage_percent"].values()) for column in columns)
    rows.append((f"{' / '.join(columns[0]['coverage_percent'])} % intervals contain", *(f"{one} %" for one in within)))
    return markdown(("", *SOURCES.values()), rows)


def cell(column: Json, name: str) -> str:
    """Return a cell of a source, by the name of its row."""
    if name == "clusters / vehicles":
        return f"{column['clusters']} / {column['vehicles']}"
    if name.startswith("best minus "):
        return interval(*column["best_minus_deg"][name.removeprefix("best minus ")], sign="+")
    if name.startswith("best, "):
        part = column["by_view_or_range_deg"].get(name.removeprefix("best, "), {"clusters": 0})
        return f"{part['best']:.2f}" if part["clusters"] >= FEWEST else ""
    return interval(*column["error_deg"][name])


def interval(value: float, limits: list[float] | None, *, sign: str = "") -> str:
    """Return a value with its interval."""
    ends = f" [{', '.join(f'{end:{sign}.2f}' for end in limits)}]" if limits else ""
    return f"{value:{sign}.2f}{ends}"
