"""Figures of documents: SVG in a page, with the page's colours and font, and files for papers."""

import io
import math
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from luxloop.scenarios.document import palette
from luxloop.scenarios.document.palette import PAGE
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas
    from matplotlib.text import Text


GAP_PX = 2.0
"""Least gap between two labels, at 72 pixels per inch [px]."""
LINE = 1.25
"""Height of a line of text, as a multiple of the size of its letters."""
SLANT_DEG = 35.0
"""Angle of labels that do not fit beside each other."""


def separate_labels(canvas: "Canvas") -> None:
    """Slant the labels of a horizontal axis that collide, and hide every second one as long as any still do."""
    if not any(len(axes.get_xticks()) or len(axes.get_yticks()) for axes in canvas.axes):
        return  # a map
    canvas.draw_without_rendering()
    for axes in canvas.axes:
        if _collide(axes, "x"):
            for label in axes.get_xticklabels(which="both"):
                label.set(rotation=SLANT_DEG, ha="right", rotation_mode="anchor")
            canvas.draw_without_rendering()
        for side in ("x", "y"):
            while _collide(axes, side):
                for label in _shown(axes, side)[1::2]:
                    label.set_visible(False)


def _shown(axes: "Axes", side: str) -> "list[Text]":
    """Return the labels of an axis that are in the figure."""
    labels = axes.get_xticklabels(which="both") if side == "x" else axes.get_yticklabels(which="both")
    low, high = sorted(axes.get_xlim() if side == "x" else axes.get_ylim())
    place = 0 if side == "x" else 1
    margin = 1e-9 * (high - low)
    return [
        label
        for label in labels
        if label.get_visible() and label.get_text() and low - margin <= label.get_position()[place] <= high + margin
    ]


def _collide(axes: "Axes", side: str) -> bool:
    """Return True if two neighbouring labels of an axis overlap."""
    shown = _shown(axes, side)
    if not shown:
        return False
    boxes = [label.get_window_extent() for label in shown]
    slant = math.radians(shown[0].get_rotation())
    if not slant:
        return any(one.padded(0.5 * GAP_PX).overlaps(other) for one, other in pairwise(boxes))
    # Slanted labels are parallel lines of text that end below their ticks.
    line = LINE * max(float(label.get_fontsize()) for label in shown) * axes.figure.dpi / 72.0
    return any(abs(right.x1 - left.x1) * math.sin(slant) < line + GAP_PX for left, right in pairwise(boxes))


STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.size": 9.0,
    "axes.edgecolor": palette.FAINT,
    "axes.labelcolor": palette.MUTED,
    "axes.titlecolor": palette.INK,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": palette.LINE,
    "grid.linewidth": 0.6,
    "xtick.color": palette.MUTED,
    "ytick.color": palette.MUTED,
    "text.color": palette.INK,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.6,
}


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure, for pages as SVG and for files."""

    name: str
    """Anchor in the page, and the name of a file without its suffix; unique in both."""
    title: str
    caption: str
    """Description of the contents, and reading instructions; with the title, the text for screen readers."""
    size_in: tuple[float, float]
    """Width and height [inch], at 72 pixels per inch."""
    paint: "Callable[[Canvas], None]"
    """Draws on an empty canvas."""
    wide: bool = False
    """True if the figure takes the page's whole width; on a narrow screen it scrolls in its box."""
    frame: int | None = None
    """Number of the frame of a bird's-eye picture."""

    @cached_property
    def svg(self) -> Markup:
        """The figure as a part of a page."""
        text = io.StringIO()
        with self.canvas("none") as canvas:
            for axes in canvas.axes:
                axes.set_facecolor("none")
            canvas.savefig(text, format="svg", metadata={"Date": None})
        return _embed(text.getvalue(), f"{self.title}. {self.caption}", self.size_in)

    @contextmanager
    def canvas(self, background: str) -> "Iterator[Canvas]":
        """Yield the painted canvas, on which no two labels of an axis overlap; write it inside of the context."""
        import matplotlib
        from matplotlib.figure import Figure as Canvas

        with matplotlib.rc_context({**STYLE, "svg.hashsalt": self.name, "pdf.fonttype": 42}):
            canvas = Canvas(figsize=self.size_in, layout="constrained", facecolor=background)
            self.paint(canvas)
            separate_labels(canvas)
            yield canvas

    def drawn(self) -> "Figure":
        """Return the figure with its SVG, without the data that it is painted from."""
        svg, found = self.svg, replace(self, paint=_blank)
        found.__dict__["svg"] = svg  # the cached property
        return found

    def save(self, folder: Path, formats: Iterable[str]) -> list[Path]:
        """Write the figure in each of these formats.

        Raises
        ------
        OutputError
            The folder cannot be written.
        """
        paths = [folder / f"{self.name}.{name}" for name in formats]
        with self.canvas(PAGE) as canvas:
            heading = textwrap.fill(self.title, int(LETTERS_PER_INCH * self.size_in[0]))
            canvas.suptitle(heading, x=0.01, ha="left", fontsize=10)
            for path in paths:
                _write(canvas, path)
        return paths


def _blank(canvas: "Canvas") -> None:
    """Draw nothing."""


def note(axes: "Axes", text: str) -> None:
    """Write a note in the middle of empty axes."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=palette.MUTED)


def _embed(svg: str, alternative: str, size_in: tuple[float, float]) -> Markup:
    """Convert an SVG file to a part of a page: no prolog, no duplicate ids, coordinates with two decimals."""
    body = svg[svg.index("<g id=") : svg.rindex("</svg>")]
    body = re.sub(r'<style type="text/css">.*?</style>', "", body, flags=re.DOTALL)
    body = re.sub(r'<g id="[^"]*"', "<g", body)
    # Coordinates are in tags; numbers in text stay.
    body = re.sub(r"<[^>]*>", lambda tag: re.sub(r"(\d\.\d\d)\d+", r"\1", tag[0]), body)
    body = re.sub(r"M ([\d.]+) ([\d.]+) \nL \1 \2 ?\n?", r"M\1 \2h0", body)  # dots
    width, height = (72.0 * side for side in size_in)
    opening = f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{escape(alternative)}">'
    return Markup(opening + palette.by_reference(body) + "</svg>")


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
    with atomic_file.writing(folder):
        folder.mkdir(parents=True, exist_ok=True)


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


def _write(canvas: "Canvas", path: Path) -> None:
    name = path.suffix[1:]
    with atomic_file.writing(path), atomic_file.create(path) as partial:
        canvas.savefig(partial, dpi=PIXELS_PER_INCH, format=name, **FORMATS[name])
