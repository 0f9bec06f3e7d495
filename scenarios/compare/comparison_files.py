"""Files of a comparison: `--report FILE.html`, `FILE.md`, or a folder for both."""

from pathlib import Path

from luxloop.scenarios.document import html, markdown
from luxloop.scenarios.document.document import Document
from luxloop.scenarios.errors import OutputError

RENDERERS = {".html": html.page, ".md": markdown.markdown}
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
        return [report / f"{STEM}{suffix}" for suffix in RENDERERS]
    if report.suffix not in RENDERERS:
        raise OutputError(f"--report {report}: give a name that ends in .html or .md, or a folder for both")
    return [report]


def write(files: list[Path], document: Document) -> None:
    """Write the files, each in the format of its name.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    for file in files:
        html.write_text(file, RENDERERS[file.suffix](document), "--report")
