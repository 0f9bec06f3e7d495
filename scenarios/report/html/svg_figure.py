"""Figures as SVG embedded in a page, with the page's colours and font."""

import io
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from luxloop.scenarios.report.html import palette

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


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of a page."""

    name: str
    """Anchor in the page."""
    title: str
    caption: str
    """Description of the contents, and reading instructions."""
    svg: Markup
    wide: bool = False
    """True if the figure takes the page's whole width; on a narrow screen it scrolls in its box."""
    size_in: tuple[float, float] = (0.0, 0.0)
    """Width and height [inch]."""
    frame: int | None = None
    """Number of the frame of a bird's-eye picture."""
    paint: "Callable[[Canvas], None] | None" = None
    """Draws the figure again, for a file; None where its data are no longer needed."""


def draw(
    name: str,
    title: str,
    caption: str,
    size_in: tuple[float, float],
    on: "Callable[[Canvas], None]",
    wide: bool = False,
    frame: int | None = None,
) -> Figure:
    """Draw a figure.

    Parameters
    ----------
    name
        Anchor, unique in the page.
    title, caption
        Text above the figure, and its alternative text for screen readers.
    size_in
        Width and height [inch], at 72 pixels per inch.
    on
        Draws on an empty canvas.
    wide, frame
        See `Figure`.
    """
    import matplotlib
    from matplotlib.figure import Figure as Canvas

    with matplotlib.rc_context({**STYLE, "svg.hashsalt": name}):
        canvas = Canvas(figsize=size_in, layout="constrained", facecolor="none")
        on(canvas)
        for axes in canvas.axes:
            axes.set_facecolor("none")
        text = io.StringIO()
        canvas.savefig(text, format="svg", metadata={"Date": None})
    return Figure(
        name, title, caption, _embed(text.getvalue(), f"{title}. {caption}", size_in), wide, size_in, frame, on
    )


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
