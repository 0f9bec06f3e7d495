"""Documents and tables as lines, for terminals, logs and files. Figures, players and folded blocks are left out."""

import os
import re
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import NamedTuple, Self

from luxloop.printable import is_terminal, printable
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

BOLD, DIM, CYAN = "1", "2", "36"
CODES: dict[Style, str] = {
    "": "",
    "bold": BOLD,
    "dim": DIM,
    "good": "32",
    "warn": "33",
    "bad": "31",
    "info": CYAN,
    "code": "",
}
"""Parameters of the escape sequence that starts each style in a terminal."""

BETWEEN = "   "
"""Between the columns of a table."""
WORD = re.compile(r"\s*\S+")


class Piece(NamedTuple):
    """Letters in one style."""

    text: str
    codes: str = ""
    """As in `CODES`; several are separated by a semicolon."""


@dataclass(frozen=True, slots=True)
class Line:
    """Letters with their styles."""

    pieces: tuple[Piece, ...] = ()

    @classmethod
    def of(cls, *pieces: str | tuple[str, str]) -> Self:
        """Return a line of printable texts, and of such texts with codes."""
        parts = ((piece, "") if isinstance(piece, str) else piece for piece in pieces)
        return cls(tuple(Piece(printable(text), codes) for text, codes in parts))

    @property
    def plain(self) -> str:
        """The letters."""
        return "".join([piece.text for piece in self.pieces])

    @property
    def coloured(self) -> str:
        """The letters, with escape sequences around those that have a style."""
        return "".join(f"\x1b[{codes}m{text}\x1b[0m" if codes else text for text, codes in self.pieces)

    def cut(self, start: int, end: int) -> "Line":
        """Return the letters from `start` to before `end`."""
        found, at = [], 0
        for text, codes in self.pieces:
            if part := text[max(start - at, 0) : max(end - at, 0)]:
                found.append(Piece(part, codes))
            at += len(text)
        return Line(tuple(found))


def print_lines(printed: Iterable[Line]) -> None:
    """Print lines on standard output, on a terminal in colour; it may have no sign for some letters."""
    in_colour = (
        is_terminal(sys.stdout) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") not in ("dumb", "unknown")
    )
    encoding = sys.stdout.encoding or "utf-8"
    for line in printed:
        letters = line.coloured if in_colour else line.plain
        sys.stdout.write(letters.encode(encoding, "replace").decode(encoding) + "\n")


def lines(shown: Document | Table, width: int) -> list[Line]:
    """Return a table, or a document: the answer, then its sections without headings, since tables have titles."""
    if isinstance(shown, Table):
        return table(shown, width)
    found: list[Line] = []
    for part in _parts(shown):
        found += [*(table(part, width) if isinstance(part, Table) else wrapped(part, width)), Line()]
    return found


def narrowest(shown: Document | Table) -> int:
    """Return the width of lines on which no word is broken, and no cell that should stay on one line."""
    parts = [shown] if isinstance(shown, Table) else _parts(shown)
    return max((_narrowest(part) for part in parts), default=0)


def _narrowest(part: Table | Line) -> int:
    if isinstance(part, Line):
        return _longest_word(part.plain)
    return _Layout.of(part).narrowest


def _parts(shown: Document) -> Iterator[Table | Line]:
    """Yield the tables, and the other blocks as one line each, which may contain line breaks."""
    yield answer(shown.answer)
    yield from _blocks(shown.lead)
    for section in shown.shown:
        if not section.page_only:
            yield from _blocks(section.blocks)


def answer(said: Answer) -> Line:
    """Return the verdict in capitals, and the sentence."""
    if not said.verdict:
        return Line.of((said.sentence, BOLD))
    return Line.of((said.verdict.upper(), f"{BOLD};{CODES[said.style]}"), f": {said.sentence}")


def text(words: Words, *styles: Style) -> Line:
    """Return words in their styles and further ones, with bad outcomes in capitals."""
    further = [CODES[style] for style in styles]
    return Line.of(
        *(
            (
                span.text.upper() if span.badge and span.style == "bad" else span.text,
                ";".join(filter(None, [*further, CODES[span.style]])),
            )
            for span in spans(words)
        )
    )


def _blocks(blocks: Sequence[Block]) -> Iterator[Table | Line]:
    for block in blocks:
        match block:
            case Table():
                if block.rows:
                    yield block
            case Paragraph():
                yield text(block.words, block.style)
            case Bullets():
                items = [Line.of((block.title, BOLD)), *map(text, block.items)][not block.title :]
                yield Line(tuple(piece for item in items for piece in (*item.pieces, Piece("\n")))[:-1])
            case Facts():
                yield Line.of("; ".join(f"{name} {plain(value)}" for name, value in block.values.items()))
            case Preformatted():
                yield Line.of((block.text, CYAN))
            case Figure() | Player() | Legend() | Folded():
                pass


class _Layout(NamedTuple):
    """Cells of a table, and the widths of its columns [characters]."""

    rows: list[list[Line]]
    """Heading and rows."""
    whole: list[int]
    """Widths without any line break."""
    least: list[int]
    """Widths without a broken word, and without a break in cells that should stay on one line."""

    @classmethod
    def of(cls, shown: Table) -> "_Layout":
        """Measure a table."""
        heading = [text(column.head, "bold") for column in shown.columns]
        cells = [
            [text(cell, row.style, column.style) for cell, column in zip(row.cells, shown.columns, strict=True)]
            for row in shown.rows
        ]
        rows = [heading, *cells]
        letters = [[row[column].plain for row in rows] for column in range(len(shown.columns))]
        whole = [max(map(_widest_line, column)) for column in letters]
        least = [
            natural if column.no_wrap else max(map(_longest_word, cells))
            for column, natural, cells in zip(shown.columns, whole, letters, strict=True)
        ]
        return cls(rows, whole, least)

    @property
    def narrowest(self) -> int:
        """Width of lines on which the columns have their least widths."""
        return sum(self.least) + len(BETWEEN) * (len(self.least) - 1)

    def widths(self, width: int) -> list[int]:
        """Return the widths of the columns on lines of a width; the widest are shortened first.

        All columns are broken if the line is too short for those that should stay on one line.
        """
        found = list(self.whole)
        least = self.least if self.narrowest <= width else [1] * len(found)
        excess = sum(found) + len(BETWEEN) * (len(found) - 1) - width
        for _ in range(excess):
            longer = [(size, place) for place, size in enumerate(found) if size > least[place]]
            if not longer:
                break
            found[max(longer)[1]] -= 1
        return found


def table(shown: Table, width: int) -> list[Line]:
    """Return a table that keeps names and numbers on one line as long as it fits, and cuts no letter."""
    layout = _Layout.of(shown)
    widths = layout.widths(width)
    right = [column.right for column in shown.columns]
    total = sum(widths) + len(BETWEEN) * (len(widths) - 1)
    heading = [wrapped(cell, size) for cell, size in zip(layout.rows[0], widths, strict=True)]
    highest = max(map(len, heading))
    found = wrapped(Line.of((shown.title, BOLD)), total) if shown.title else []
    found += _side_by_side([[Line()] * (highest - len(cell)) + cell for cell in heading], widths, right)
    found.append(Line.of("─" * total))
    for row, cells in zip(shown.rows, layout.rows[1:], strict=True):
        found += _side_by_side([wrapped(cell, size) for cell, size in zip(cells, widths, strict=True)], widths, right)
        if row.end_section and row is not shown.rows[-1]:
            found.append(Line())
    return found


def _side_by_side(cells: Sequence[Sequence[Line]], widths: Sequence[int], right: Sequence[bool]) -> list[Line]:
    """Return the lines of a row, of the lines of its cells."""
    found = []
    for parts in zip_longest(*cells, fillvalue=Line()):
        pieces: list[Piece] = []
        for part, width, is_right in zip(parts, widths, right, strict=True):
            free = Piece(" " * (width - _columns(part.plain)))
            pieces += [free, *part.pieces] if is_right else [*part.pieces, free]
            pieces.append(Piece(BETWEEN))
        while pieces and not pieces[-1].text.strip():
            pieces.pop()
        found.append(Line(tuple(pieces)))
    return found


def wrapped(line: Line, width: int) -> list[Line]:
    """Return lines of at most this width, broken at line breaks, between words, and within longer words."""
    letters = line.plain
    if "\n" not in letters and _columns(letters) <= width:
        return [line]
    found, at = [], 0
    for paragraph in letters.split("\n"):
        found += [line.cut(at + start, at + end) for start, end in _breaks(paragraph, width)]
        at += len(paragraph) + 1
    return found


def _breaks(letters: str, width: int) -> Iterator[tuple[int, int]]:
    """Yield where each line of a paragraph starts and ends."""
    start = end = 0
    for word in WORD.finditer(letters):
        if end > start and _columns(letters[start : word.end()]) > width:
            yield start, end
            start = word.end() - len(word[0].lstrip())
        end = word.end()
        while _columns(letters[start:end]) > width:
            fitting = _fitting(letters[start:end], width)
            yield start, start + fitting
            start += fitting
    yield start, end


def _fitting(letters: str, width: int) -> int:
    """Return how many letters fit on a line, at least one."""
    return max(1, max(count for count in range(width + 1) if _columns(letters[:count]) <= width))


def _columns(letters: str) -> int:
    """Return the columns that letters take in a terminal: two for letters of East Asia and emojis."""
    if letters.isascii():
        return len(letters)
    return sum(
        0 if unicodedata.combining(letter) else 2 if unicodedata.east_asian_width(letter) in "WF" else 1
        for letter in letters
    )


def _widest_line(letters: str) -> int:
    return max(map(_columns, letters.split("\n")))


def _longest_word(letters: str) -> int:
    return max(map(_columns, letters.split()), default=0)
