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
    "faint": Tone("#7f8890", "#7b848d"),
    "blue": Tone("#0072b2", "#58b0e6"),
    "orange": Tone("#b97d00", "#f0b02e"),
    "green": Tone("#008f68", "#35cc9f"),
    "red": Tone("#c24c00", "#ff8b4d"),
    "purple": Tone("#a84f82", "#e49cc6"),
    "sky": Tone("#2f8cc4", "#9ad5f7"),
    "good": Tone("#007653", "#34cb9e"),
    "warn": Tone("#8f6200", "#efaf2d"),
    "bad": Tone("#b84800", "#fe8a4c"),
}
"""Colours by name. Contrasts meet WCAG 2.1 AA: 4.5 to 1 for text, in `TEXT_NAMES`, and 3 to 1 for marks in figures.
`line` is for grids and rules only, which carry no information.

Figures are drawn with the light variants, which are all different, and `by_reference` replaces them by references to
the page's colours."""

PAGE, PANEL, LINE, INK, MUTED, FAINT, BLUE, ORANGE, GREEN, RED, PURPLE, SKY, GOOD, WARN, BAD = (
    tone.light for tone in TONES.values()
)

SERIES_NAMES = ("blue", "orange", "green", "purple", "red", "sky")
SERIES = tuple(TONES[name].light for name in SERIES_NAMES)
"""Colour cycle of methods and curves, by name and as colours."""
TEXT_NAMES = ("blue", "warn", "good", "purple", "bad", "muted")
TEXT_SERIES = tuple(TONES[name].light for name in TEXT_NAMES)
"""Colour cycle of what has text in or on it: bars of tracks, and trackers with the ids of their tracks."""


def by_reference(svg: str) -> str:
    """Replace the colours of a figure by references to the page's colours."""
    for name, tone in TONES.items():
        svg = svg.replace(tone.light, f"var(--{name})")
    return svg
