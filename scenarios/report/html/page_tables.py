"""Tables of an HTML page, converted from those of the printed report so that both show the same numbers."""

from dataclasses import dataclass

from rich.table import Table


@dataclass(frozen=True, slots=True)
class Cell:
    """Text of a cell, True if it is right-aligned, and the target of its link, if any."""

    text: str
    right: bool
    href: str = ""


@dataclass(frozen=True, slots=True)
class Row:
    """Cells of a row, and its style: `bold`, `dim` or empty."""

    cells: list[Cell]
    style: str


@dataclass(frozen=True, slots=True)
class PageTable:
    """Table of a page."""

    title: str
    head: list[Cell]
    rows: list[Row]


def page_table(table: Table) -> PageTable:
    """Convert a printed table: title, columns and rows."""
    right = [column.justify == "right" for column in table.columns]
    lines = zip(*(column.cells for column in table.columns), strict=True)
    return PageTable(
        title=str(table.title),
        head=_cells([column.header for column in table.columns], right),
        rows=[Row(_cells(line, right), str(row.style or "")) for row, line in zip(table.rows, lines, strict=True)],
    )


def _cells(texts: object, right: list[bool]) -> list[Cell]:
    assert isinstance(texts, list | tuple)
    return [Cell(str(text), at_right) for text, at_right in zip(texts, right, strict=True)]
