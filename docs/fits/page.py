"""Generated parts of fitting.md, between `<!-- NAME -->` and the next `<!-- end -->`."""

from pathlib import Path

DOCS = Path(__file__).parents[1]
PAGE, PICTURES = DOCS / "fitting.md", DOCS / "pictures"


def replace(name: str, text: str, page: Path = PAGE) -> None:
    """Replace a generated part.

    Raises
    ------
    ValueError
        The page has no part of this name.
    """
    before, mark, rest = page.read_text(encoding="utf-8").partition(f"<!-- {name} -->\n")
    _, end, after = rest.partition("<!-- end -->")
    if not (mark and end):
        raise ValueError(f"{page}: no part <!-- {name} --> ... <!-- end -->")
    page.write_text(f"{before}{mark}{text}\n{end}{after}", encoding="utf-8")
