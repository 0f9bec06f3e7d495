"""Table of a document."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from luxloop.scenarios.document.words import Span, Style, Words, spans

if TYPE_CHECKING:
    from rich.console import RenderableType

Cell = tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """Heading and alignment of a column; the unit is in the heading."""

    head: str
    right: bool = False
    no_wrap: bool = False
    """True if a terminal keeps its cells on one line as long as the table fits."""
    style: Style = ""


@dataclass(frozen=True, slots=True)
class Row:
    """A cell for each column."""

    cells: tuple[Cell, ...]
    style: Style = ""
    end_section: bool = False
    """True if a terminal draws a line below."""


@dataclass(slots=True)
class Table:
    """Columns and rows below a title."""

    title: str
    columns: list[Column] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    stacked: bool = False
    """True if a phone shows each row as a paragraph: tables with sentences in their cells."""

    def add_column(
        self, head: str, *, justify: Literal["left", "right"] = "left", no_wrap: bool = False, style: Style = ""
    ) -> None:
        """Add a column."""
        self.columns.append(Column(head, justify == "right", no_wrap, style))

    def add_row(self, *cells: Words, style: Style = "", end_section: bool = False) -> None:
        """Add a row; missing cells at its end are empty."""
        missing = len(self.columns) - len(cells)
        if missing < 0:
            raise ValueError(f"{self.title}: {len(cells)} cells for {len(self.columns)} columns")
        self.rows.append(Row((*map(spans, cells), *[()] * missing), style, end_section))

    def __rich__(self) -> "RenderableType":
        """Return the table for a terminal."""
        from luxloop.scenarios.document.terminal import table

        return table(self)
