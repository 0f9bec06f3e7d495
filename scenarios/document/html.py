"""Documents as HTML: one template and one style for every page, without any request to a network."""

import base64
import hashlib
import re
from collections.abc import Iterable, Sequence
from functools import cache
from importlib import resources
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from luxloop.scenarios.document.document import Block, Document, Folded, Span, Table, Words, spans
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import TONES
from luxloop.scenarios.files import atomic_file

LINKED = 3
"""Least number of sections with a list of links to them."""
PIXELS_PER_INCH = 92.0
"""Largest scale of a figure on a wide screen: its letters are about as large as those of the text."""


def page(document: Document) -> str:
    """Return a document as a page in one file."""
    return _environment().get_template("page.html.j2").render(document=document)


def fragment(document: Document) -> str:
    """Return answer and tables of a document without style, for notebooks."""
    return _environment().get_template("fragment.html.j2").render(document=document)


def write(out: Path, document: Document) -> None:
    """Write a page.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    atomic_file.save_text(out, page(document))


@cache
def _environment() -> Environment:
    """Return the templates; all values are escaped, so that the contents of a run are never markup."""
    environment = Environment(
        loader=PackageLoader("luxloop.scenarios.document"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(tones=TONES, linked=LINKED, scale=PIXELS_PER_INCH)
    environment.globals.update(script=script, script_hash=script_hash, groups=groups, kind=kind)
    environment.filters.update(words=words, name=breakable)
    return environment


def words(shown: Words) -> Markup:
    """Return words as HTML."""
    return Markup("").join(map(_span, spans(shown)))


def breakable(shown: Words) -> Markup:
    """Return the words of a row's heading, which a narrow column may break after points and underscores of names."""
    return Markup(re.sub(r"(?<=[a-z])([._])(?=\w)(?![^<]*>)", r"\1<wbr>", str(words(shown))))


def _span(span: Span) -> Markup:
    text = span.drawing + escape(span.text).replace("\n", Markup("<br>"))
    if span.link:
        text = Markup('<a href="{}">{}</a>').format(span.link, text)
    if span.style == "code":
        text = Markup("<code>{}</code>").format(text)
    names = " ".join(["badge"] * span.badge + [span.style] * (span.style not in ("", "code")))
    if not (names or span.note):
        return text
    note = Markup(' title="{}"').format(span.note) if span.note else ""
    return Markup('<span class="{}"{}>{}</span>').format(names, note, text)


def kind(block: Block) -> str:
    """Return the name of the macro of a block."""
    return type(block).__name__.lower()


def groups(blocks: Iterable[Block]) -> list[tuple[str, Sequence[Sequence[Block]]]]:
    """Return blocks in rows: figures and tables side by side, each figure with the folded blocks below it."""
    found: list[tuple[str, list[list[Block]]]] = []
    for block in blocks:
        former = found[-1][0] if found else ""
        if isinstance(block, Folded) and former == "gallery":
            found[-1][1][-1].append(block)
            continue
        name = "gallery" if isinstance(block, Figure) else "tables" if isinstance(block, Table) else ""
        if name and name == former:
            found[-1][1].append([block])
        else:
            found.append((name, [[block]]))
    return [(name, items) for name, items in found]


@cache
def script() -> Markup:
    """Return the script of the frame player, the only one of any page."""
    return Markup(
        (resources.files("luxloop.scenarios.document") / "templates" / "player.js").read_text(encoding="utf-8")
    )


def script_hash() -> str:
    """Return the source expression of a content security policy that allows this script and no other one."""
    return "sha256-" + base64.b64encode(hashlib.sha256(script().encode()).digest()).decode()
