"""Files of a comparison: `--report FILE.html`, `FILE.md`, or a folder for both."""

from pathlib import Path

from luxloop.scenarios.compare.comparison import Comparison
from luxloop.scenarios.compare.comparison_markdown import markdown
from luxloop.scenarios.compare.comparison_page import comparison_page
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.report.html import pages

MAKERS = {".html": comparison_page, ".md": markdown}
STEM = "comparison"
"""Name of the files in a folder."""


def files_of(report: Path) -> list[Path]:
    """Return the files to write.

    Raises
    ------
    OutputError
        The name ends neither like a page, nor like Markdown, nor like a folder.
    """
    if report.is_dir() or not report.suffix:
        return [report / f"{STEM}{suffix}" for suffix in MAKERS]
    if report.suffix not in MAKERS:
        raise OutputError(f"--report {report}: give a name that ends in .html or .md, or a folder for both")
    return [report]


def write(files: list[Path], comparison: Comparison, base: str, head: str) -> None:
    """Write the files, each in the format of its name.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    for file in files:
        pages.write(file, MAKERS[file.suffix](comparison, base, head), "--report")
