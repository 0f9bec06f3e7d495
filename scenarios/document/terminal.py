"""Documents and tables in a terminal, by rich. Figures, players and folded blocks are left out."""

from collections.abc import Iterator, Sequence

from rich import box
from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from luxloop.scenarios.document.document import (
    Answer,
    Block,
    Bullets,
    Document,
    Facts,
    Folded,
    Legend,
    Paragraph,
    Player,
    Preformatted,
    Style,
    Table,
    Words,
    plain,
    spans,
)
from luxloop.scenarios.document.figure import Figure

COLORS: dict[Style, str] = {
    "": "",
    "bold": "bold",
    "dim": "dim",
    "good": "green",
    "warn": "yellow",
    "bad": "red",
    "info": "cyan",
    "code": "",
}


def document(shown: Document) -> Group:
    """Return a document: the answer, then its sections without headings, since tables have titles."""
    parts: list[RenderableType] = [answer(shown.answer), *_blocks(shown.lead)]
    for section in shown.shown:
        if not section.page_only:
            parts += _blocks(section.blocks)
    return Group(*(Padding(part, (0, 0, 1, 0), expand=False) for part in parts))


def answer(said: Answer) -> Text:
    """Return the verdict in capitals, and the sentence."""
    if not said.verdict:
        return Text(said.sentence, style="bold")
    return Text.assemble((said.verdict.upper(), f"bold {COLORS[said.style]}"), f": {said.sentence}")


def text(words: Words) -> Text:
    """Return words with their colours, and bad outcomes in capitals."""
    shown = [(span.text.upper() if span.badge and span.style == "bad" else span.text, span) for span in spans(words)]
    return Text.assemble(*((letters, COLORS[span.style]) for letters, span in shown))


def _blocks(blocks: Sequence[Block]) -> Iterator[RenderableType]:
    for block in blocks:
        match block:
            case Table():
                if block.rows:
                    yield table(block)
            case Paragraph():
                found = text(block.words)
                found.style = COLORS[block.style]
                yield found
            case Bullets():
                title = [Text(block.title, style="bold")] if block.title else []
                yield Text("\n").join([*title, *map(text, block.items)])
            case Facts():
                yield Text("; ".join(f"{name} {plain(value)}" for name, value in block.values.items()))
            case Preformatted():
                yield Text(block.text, style="cyan")
            case Figure() | Player() | Legend() | Folded():
                pass


def table(shown: Table) -> RichTable:
    """Return a table that keeps names and numbers on one line as long as it fits."""
    # The title is a Text, because rich would parse [deg] in a plain string as a style.
    title = Text(shown.title, style="bold") if shown.title else None
    found = WholeTable(title=title, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in shown.columns:
        justify = "right" if column.right else "left"
        head = Text(column.head)
        found.add_column(head, justify=justify, no_wrap=column.no_wrap, style=COLORS[column.style])  # type: ignore[arg-type]
    for row in shown.rows:
        found.add_row(*map(text, row.cells), style=COLORS[row.style], end_section=row.end_section)
    return found


class WholeTable(RichTable):
    """Table that wraps and folds its cells on narrow lines; rich would end them in ellipses."""

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Return the width in which no cell is folded, as the minimum."""
        needed = self._needed_width(console, options)
        return Measurement(needed, max(needed, super().__rich_measure__(console, options).maximum))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Allow breaks in all columns if the line is too short for those that should stay on one line."""
        if self._needed_width(console, options) > options.max_width:
            for column in self.columns:
                column.no_wrap = False
        for column in self.columns:
            column.overflow = "fold"
        yield from super().__rich_console__(console, options)

    def _needed_width(self, console: Console, options: ConsoleOptions) -> int:
        """Return the width of lines on which columns without breaks are whole, and words of the others, too."""
        unlimited = options.update(max_width=10_000)

        def width(cell: RenderableType, no_wrap: bool) -> int:
            measured = Measurement.get(console, unlimited, cell)
            return measured.maximum if no_wrap else measured.minimum

        widest = [
            max(width(cell, column.no_wrap) for cell in (column.header, *column.cells)) for column in self.columns
        ]
        _, right, _, left = self.padding
        return sum(widest) + (len(widest) - 1) * (right + left + (1 if self.box else 0))
