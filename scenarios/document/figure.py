"""Figures of documents: SVG in a page, with the page's colours and font, and files for papers."""

import io
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from luxloop.scenarios.document import palette
from luxloop.scenarios.document.axis_labels import separate_labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

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
