"""Parts of the pages of the documentation."""

import re
from pathlib import Path

from support.paths import DOCS


def chapter(page: str, title: str) -> str:
    """Return a second-level section of a page of docs/, with its subsections."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)[1]


def block(page: Path, name: str) -> str:
    """Return the text of a generated part of a page."""
    from blocks.page import parts

    return next(part.text for part in parts(page) if part.name == name)
