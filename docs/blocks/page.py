"""Generated parts of pages: `<!-- NAME | command | stamp | claim | ... -->`, text, `<!-- end -->`."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from blocks.catalog import BLOCKS
from blocks.stamps import stamp

PART = re.compile(r"<!-- (?!end )([^\n]+?) -->\n(.*?)\n?<!-- end -->", re.DOTALL)
SEPARATOR = " | "
STAMP = "luxloop "
CONTENT = re.compile(r"\bcontent (\w+)")


class Part(NamedTuple):
    """A generated part of a page."""

    page: Path
    name: str
    command: str
    stamp: str
    claims: tuple[str, ...]
    text: str

    @property
    def digest(self) -> str:
        """Digest of text and pictures when they were made; empty without a stamp."""
        found = CONTENT.search(self.stamp)
        return found[1] if found else ""

    @property
    def mark(self) -> str:
        """The line above the text."""
        fields = (self.name, self.command, self.stamp, *self.claims)
        return f"<!-- {SEPARATOR.join(field for field in fields if field)} -->"


def pages(root: Path) -> list[Path]:
    """Return the pages that have blocks."""
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def parts(page: Path) -> Iterator[Part]:
    """Yield the generated parts of a page."""
    for match in PART.finditer(page.read_text(encoding="utf-8")):
        yield parsed(page, match[1], match[2])


def parsed(page: Path, mark: str, text: str) -> Part:
    """Return a part from the fields of its mark: claims have brackets, the stamp begins with luxloop's version."""
    name, *fields = mark.split(SEPARATOR)
    claims = tuple(field for field in fields if field.startswith("["))
    made = next((field for field in fields if re.match(rf"{STAMP}\d", field)), "")
    command = next((field for field in fields if field not in (*claims, made)), "")
    return Part(page, name, command, made, claims, text)


def write(page: Path, name: str, text: str | None, hashes: str) -> None:
    """Replace the parts of a name on a page; without a text, only their pictures are new."""

    def renewed(match: re.Match[str]) -> str:
        part = parsed(page, match[1], match[2])
        if part.name != name:
            return match[0]
        shown = part.text if text is None else text
        made = stamp(page, shown, hashes) if hashes else ""
        return f"{part._replace(command=BLOCKS[name].command, stamp=made).mark}\n{shown}\n<!-- end -->"

    before = page.read_text(encoding="utf-8")
    after = PART.sub(renewed, before)
    if after != before:
        page.write_text(after, encoding="utf-8")
