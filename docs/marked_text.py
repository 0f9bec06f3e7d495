"""Generated parts of pages, between `<!-- mark -->` and `<!-- end -->`."""

from pathlib import Path


def replace(page: Path, mark: str, text: str) -> None:
    """Replace the text between `<!-- mark -->` and the next `<!-- end -->` of a page."""
    start, end = f"<!-- {mark} -->", "<!-- end -->"
    head, rest = page.read_text(encoding="utf-8").split(start)
    _, tail = rest.split(end, 1)
    page.write_text(f"{head}{start}\n{text}\n{end}{tail}", encoding="utf-8")
