"""Colours of pages and figures, for light and dark screens.

The data colours are those of Okabe and Ito (2008, Color Universal Design), which colour-blind people can distinguish,
with lighter variants for dark backgrounds.
"""

from typing import NamedTuple


class Tone(NamedTuple):
    """A colour for light and dark backgrounds."""

    light: str
    dark: str


TONES = {
    "page": Tone("#fdfdfc", "#15171b"),
    "panel": Tone("#f3f4f3", "#1e2127"),
    "line": Tone("#d4d7d9", "#3a3f47"),
    "ink": Tone("#1d2125", "#e6e8ea"),
    "muted": Tone("#5b646c", "#a0a8b0"),
    "faint": Tone("#9aa3aa", "#727b84"),
    "blue": Tone("#0072b2", "#58b0e6"),
    "orange": Tone("#c08300", "#f0b02e"),
    "green": Tone("#008f68", "#35cc9f"),
    "red": Tone("#c94f00", "#ff8b4d"),
    "purple": Tone("#b0568a", "#e49cc6"),
    "sky": Tone("#3796cf", "#9ad5f7"),
    "good": Tone("#007653", "#34cb9e"),
    "warn": Tone("#8f6200", "#efaf2d"),
    "bad": Tone("#b84800", "#fe8a4c"),
}
"""Colours by name; `good`, `warn` and `bad` are for text, which needs more contrast than marks in figures.

Figures are drawn with the light variants, which are all different, and `by_reference` replaces them by references to
the page's colours."""

PAGE, PANEL, LINE, INK, MUTED, FAINT, BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GOOD, WARN, BAD = (
    tone.light for tone in TONES.values()
)

SERIES = (BLUE, ORANGE, GREEN, PURPLE, RED, SKY)
"""Colour cycle of tracks and methods."""


def by_reference(svg: str) -> str:
    """Replace the colours of a figure by references to the page's colours."""
    for name, tone in TONES.items():
        svg = svg.replace(tone.light, f"var(--{name})")
    return svg
