"""Document: its answer in one sentence, and sections of sentences, tables and figures.

A page, the text in a terminal, the Markdown of a comment and JSON are renderings of one document, so that they always
agree.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from markupsafe import Markup

from luxloop.scenarios.document.figure import Figure

Style = Literal["", "bold", "dim", "good", "warn", "bad", "info", "code"]
"""`good`, `warn`, `bad` and `info` are colours of outcomes, `code` is for names that users type."""


@dataclass(frozen=True, slots=True)
class Span:
    """Words in one style."""

    text: str
    style: Style = ""
    link: str = ""
    """Address, or the anchor of a section or figure after a `#`."""
    badge: bool = False
    """True for the outcome of a page, a run or a check; it is framed on pages."""
    note: str = ""
    """Explanation that a page shows when the pointer rests on the words."""
    drawing: Markup = Markup("")  # noqa: RUF009 - an immutable text
    """Small drawing before the words, on pages only."""

    def __str__(self) -> str:
        return self.text


Words = str | Span | tuple[str | Span, ...]
"""Contents of a sentence or of a cell."""


def spans(words: Words) -> tuple[Span, ...]:
    """Return words as spans."""
    parts = words if isinstance(words, tuple) else (words,)
    return tuple(Span(part) if isinstance(part, str) else part for part in parts)


def plain(words: Words) -> str:
    """Return words without styles."""
    return "".join(span.text for span in spans(words))


def code(text: str) -> Span:
    """Return a name or a path that users type."""
    return Span(text, "code")


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


LISTED = 8
"""Items of a list in Markdown, which a comment is made of; terminals and pages have all of them."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Verdict and main result, for a reader of one sentence."""

    sentence: str
    """Without a full stop."""
    verdict: str = ""
    """Short verdict, such as "passed" or "cannot tell"; empty for a document that judges nothing."""
    style: Style = ""
    """Colour of the verdict."""

    @property
    def badge(self) -> Span:
        """The verdict as a badge."""
        return Span(self.verdict, self.style, badge=True)


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Sentences."""

    words: Words
    style: Style = ""


@dataclass(frozen=True, slots=True)
class Bullets:
    """List of sentences, the most important first."""

    items: Sequence[Words]
    title: str = ""


@dataclass(frozen=True, slots=True)
class Facts:
    """Short values by name."""

    values: Mapping[str, Words]
    large: bool = False
    """True for main figures."""


@dataclass(frozen=True, slots=True)
class Preformatted:
    """Commands to copy, or another text with its own line breaks."""

    text: str


@dataclass(frozen=True, slots=True)
class Legend:
    """Marks of pictures with their meanings; each mark is the name of a style of the page, or `line-` and a colour."""

    marks: Sequence[tuple[str, Words]]


@dataclass(frozen=True, slots=True)
class Player:
    """Player of the frames of a run."""

    packed: str
    """Data of its script."""
    trackers: Mapping[str, str]
    """Name of the colour of each tracker, by its name."""
    marked: Mapping[int, str]
    """Frames that a button leads to, with the errors in them."""


@dataclass(frozen=True, slots=True)
class Folded:
    """Blocks that are shown when their title is clicked; a terminal leaves them out."""

    title: Words
    blocks: "Sequence[Block]"
    name: str = ""
    """Anchor, unique in the document, if something links to it."""
    opened: bool = False


Block = Paragraph | Bullets | Facts | Preformatted | Legend | Table | Figure | Player | Folded


@dataclass(frozen=True, slots=True)
class Section:
    """Blocks below a heading."""

    name: str
    """Anchor, unique in the document."""
    heading: str
    blocks: Sequence[Block]
    page_only: bool = False
    """True if a terminal leaves it out, because it is long or needs pictures."""

    @property
    def is_empty(self) -> bool:
        """True without any block but tables without rows."""
        return all(isinstance(block, Table) and not block.rows for block in self.blocks)


@dataclass(frozen=True, slots=True)
class Document:
    """Everything that a command shows about its result."""

    title: str
    answer: Answer
    lead: Sequence[Block]
    """Blocks below the answer; the first figure among them is on the first screen of a phone."""
    sections: Sequence[Section]
    """All sections that such a document can have; `shown` leaves out the empty ones."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """Figures for programs, beside verdict and answer."""
    name: str = ""
    """Name of a browser's tab; by default the title."""

    @property
    def shown(self) -> list[Section]:
        """Sections with contents."""
        return [section for section in self.sections if not section.is_empty]

    def blocks(self) -> Iterator[Block]:
        """Yield all blocks, those of folded ones, too."""
        yield from _unfolded(self.lead)
        for section in self.sections:
            yield from _unfolded(section.blocks)

    @property
    def tables(self) -> list[Table]:
        """All tables."""
        return [block for block in self.blocks() if isinstance(block, Table)]

    @property
    def figures(self) -> list[Figure]:
        """All figures."""
        return [block for block in self.blocks() if isinstance(block, Figure)]

    @property
    def player(self) -> Player | None:
        """The player of frames, if there is one."""
        return next((block for block in self.blocks() if isinstance(block, Player)), None)


def _unfolded(blocks: Sequence[Block]) -> Iterator[Block]:
    for block in blocks:
        yield block
        if isinstance(block, Folded):
            yield from _unfolded(block.blocks)


def json_text(document: Document, **more: str) -> str:
    """Return `json_data` on one line, with further keys."""
    return json.dumps({**json_data(document), **more}, allow_nan=False)


def json_data(document: Document) -> dict[str, Any]:
    """Return verdict, answer and the figures for programs; numbers without a value are None."""
    judged = {"verdict": document.answer.verdict} if document.answer.verdict else {}
    found: dict[str, Any] = finite({**judged, "answer": document.answer.sentence, **document.data})
    return found


def finite(value: Any) -> Any:
    """Replace NaN and infinity by None, and scalars of numpy by Python's, at any depth."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [finite(entry) for entry in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
