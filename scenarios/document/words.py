"""Words with a style and a link: the contents of sentences and of the cells of tables."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from markupsafe import Markup

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


def joined(parts: Iterable[Span], between: str = ", ") -> tuple[Span, ...]:
    """Return several spans with a text between them."""
    found = [part for span in parts for part in (Span(between), span)]
    return tuple(found[1:])
