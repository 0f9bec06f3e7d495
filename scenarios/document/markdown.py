"""Documents as GitHub flavoured Markdown, short enough for the comment of a pull request."""

import re
from collections.abc import Iterator, Sequence

from luxloop.scenarios.document.document import (
    LISTED,
    Block,
    Bullets,
    Document,
    Facts,
    Folded,
    Legend,
    Paragraph,
    Player,
    Preformatted,
    Span,
    Table,
    Words,
    spans,
)
from luxloop.scenarios.document.figure import Figure

SPECIAL = re.compile(r"([\\`*_\[\]<>#|~&$@])")
"""Characters with a meaning inside a line."""


def markdown(document: Document) -> str:
    """Return the title, the answer, and the sections; tables are folded, figures and folded blocks are left out."""
    verdict = f": {document.answer.verdict}" if document.answer.verdict else ""
    lines = [f"### {plain(document.title)}{verdict}", "", f"**{plain(document.answer.sentence)}.**", ""]
    lines += _blocks(document.lead)
    for section in document.shown:
        if not section.page_only:
            lines += _blocks(section.blocks)
    return "\n".join(lines)


def code(text: str) -> str:
    """Return a text as a code span on one line, also inside a table."""
    text = " ".join(text.split())
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", text)), default=0))
    space = " " if "`" in text else ""
    return f"{fence}{space}{text}{space}{fence}".replace("|", "\\|")


def plain(text: str) -> str:
    """Return a text that Markdown shows as it is written, on one line."""
    return SPECIAL.sub(r"\\\1", re.sub(r"\s+", " ", text))


def _span(span: Span) -> str:
    if span.style == "code" and span.text:
        return code(span.text)
    text = plain(span.text)
    strong = span.text and (span.style in ("bold", "bad", "good"))
    return f"**{text}**" if strong else text


def _words(words: Words) -> str:
    return "".join(map(_span, spans(words))).strip()


def _blocks(blocks: Sequence[Block]) -> Iterator[str]:
    for block in blocks:
        match block:
            case Table():
                if block.rows:
                    yield from (f"<details><summary>{plain(block.title)}</summary>", "", *_table(block), "")
                    yield from ("</details>", "")
            case Paragraph():
                yield from (_words(block.words), "")
            case Bullets():
                yield from (f"**{plain(block.title)}**", "") if block.title else ()
                yield from (f"- {_words(item)}" for item in block.items[:LISTED])
                if len(block.items) > LISTED:
                    yield f"- {len(block.items) - LISTED} more in the tables below"
                yield ""
            case Facts():
                yield from (", ".join(f"{plain(name)} {_words(value)}" for name, value in block.values.items()), "")
            case Preformatted():
                yield from ("```", block.text.replace("```", "'''"), "```", "")
            case Figure() | Player() | Legend() | Folded():
                pass


def _table(table: Table) -> list[str]:
    head = [plain(column.head) for column in table.columns]
    align = ["---:" if column.right else "---" for column in table.columns]
    rows = [[_words(cell) for cell in row.cells] for row in table.rows]
    return ["| " + " | ".join(row) + " |" for row in (head, align, *rows)]
