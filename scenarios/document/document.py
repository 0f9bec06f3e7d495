"""Document: its answer in one sentence, and sections of sentences, tables and figures.

A page, the text in a terminal, the Markdown of a comment and JSON are renderings of one document, so that they always
agree.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.table import Table
from luxloop.scenarios.document.words import Span, Style, Words

if TYPE_CHECKING:
    from rich.console import RenderableType


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

    def __rich__(self) -> "RenderableType":
        """Return the document for a terminal."""
        from luxloop.scenarios.document.terminal import document

        return document(self)


def _unfolded(blocks: Sequence[Block]) -> Iterator[Block]:
    for block in blocks:
        yield block
        if isinstance(block, Folded):
            yield from _unfolded(block.blocks)
