"""Figures as files: PNG for a look, SVG and PDF for papers."""

import textwrap
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.document.palette import PAGE
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.files import atomic_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

FORMATS: dict[str, dict[str, Any]] = {
    "png": {"metadata": {"Software": None}},
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
}
"""Formats with the settings that leave out the time and the program, so that equal figures give equal files."""
PIXELS_PER_INCH = 110
LETTERS_PER_INCH = 11
"""Line length of the title, per inch of figure width."""


def parse_formats(text: str | None) -> list[str]:
    """Return the formats of `--figures svg,pdf`; none without the option.

    Raises
    ------
    InputError
        A format is unknown.
    """
    names = list(dict.fromkeys(part.strip() for part in text.split(","))) if text is not None else []
    for name in names:
        if name not in FORMATS:
            raise InputError(
                f"--figures {text}: {name or 'an empty name'} is no format; give some of {', '.join(FORMATS)}"
            )
    return names


def make_folder(folder: Path) -> None:
    """Make a folder for figures.

    Raises
    ------
    OutputError
        It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write there ({error.strerror}); choose another folder") from error


@contextmanager
def beside(folder: Path) -> Iterator[None]:
    """Make a folder for figures, and remove it if the body fails and leaves it empty.

    Raises
    ------
    OutputError
        It cannot be made.
    """
    make_folder(folder)
    try:
        yield
    except BaseException:
        with suppress(OSError):  # it has files of an earlier report
            folder.rmdir()
        raise


def save(figure: Figure, folder: Path, formats: Iterable[str]) -> list[Path]:
    """Write a figure in each of these formats.

    Raises
    ------
    OutputError
        The folder cannot be written.
    """
    paths = [folder / f"{figure.name}.{name}" for name in formats]
    with figure.canvas(PAGE) as canvas:
        heading = textwrap.fill(figure.title, int(LETTERS_PER_INCH * figure.size_in[0]))
        canvas.suptitle(heading, x=0.01, ha="left", fontsize=10)
        for path in paths:
            _write(canvas, path)
    return paths


def _write(canvas: "Canvas", path: Path) -> None:
    name = path.suffix[1:]
    try:
        with atomic_file.create(path) as partial:
            canvas.savefig(partial, dpi=PIXELS_PER_INCH, format=name, **FORMATS[name])
    except OSError as error:
        remedy = "free some space, or choose another folder"
        raise OutputError(f"{path}: cannot write there ({error.strerror}); {remedy}") from error
