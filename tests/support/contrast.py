"""Contrast of what a browser shows, by WCAG 2.1."""

from typing import Any

AA_TEXT, AA_MARK = 4.5, 3.0
"""Least contrast of text and of marks that carry information."""

SHOWN = """(grids) => {
  const clear = value => value === 'none' || value === 'transparent' || /, 0\\)$/.test(value);
  const behind = element => {
    for (let at = element; at; at = at.parentElement) {
      const color = getComputedStyle(at).backgroundColor;
      if (!clear(color)) return color;
    }
    return 'rgb(255, 255, 255)';
  };
  const found = [];
  const add = (kind, element, color, ground) =>
    clear(color) || found.push([kind, color, ground, element.outerHTML.slice(0, 120)]);
  const marks = ['path', 'use', 'polyline', 'circle', 'rect'];
  for (const element of document.querySelectorAll('body *')) {
    const style = getComputedStyle(element), svg = element.closest('svg');
    const words = [...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim());
    if (svg && element.tagName === 'text') add('text', element, style.fill, behind(svg));
    else if (svg && marks.includes(element.tagName) && !element.closest('defs')) {
      const faded = style.fillOpacity < 1 || style.strokeOpacity < 1 || style.opacity < 1;
      if (!faded && !grids.includes(style.stroke) && !grids.includes(style.fill)) {
        add('mark', element, style.stroke, behind(svg));
        if (clear(style.stroke)) add('mark', element, style.fill, behind(svg));
      }
    } else if (!svg && words && !['SCRIPT', 'STYLE'].includes(element.tagName))
      add('text', element, style.color, behind(element));
    else if (element.matches('.swatch')) add('mark', element, style.borderTopColor, behind(element.parentElement));
    else if (element.matches('.dot')) add('mark', element, style.backgroundColor, behind(element.parentElement));
  }
  return found;
}"""
"""Colours of texts and marks with the background; marks in a colour of `grids` or faded carry no information alone."""


def luminance(color: str) -> float:
    """Relative luminance of `rgb(r, g, b)` or `#rrggbb`."""
    if color.startswith("#"):
        channels = [int(color[k : k + 2], 16) for k in (1, 3, 5)]
    else:
        channels = [int(float(part)) for part in color[color.index("(") + 1 : -1].split(",")[:3]]
    linear = [c / 255 / 12.92 if c / 255 <= 0.04045 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    """Contrast ratio of two colours, 1 to 21."""
    darker, lighter = sorted([luminance(one), luminance(other)])
    return (lighter + 0.05) / (darker + 0.05)


def too_low(page: Any, decoration: list[str], on_marks: str) -> list[tuple[str, str, str, str]]:
    """Return texts and marks of a page whose contrast is below AA.

    Parameters
    ----------
    decoration
        Colours of grids and rules, as computed by the browser.
    on_marks
        Colour of text on coloured marks, which is the page's own and has another background.
    """
    found = page.evaluate(SHOWN, decoration)
    least = {"text": AA_TEXT, "mark": AA_MARK}
    return [
        tuple(one)
        for one in found
        if one[1] not in (on_marks, *decoration) and contrast(one[1], one[2]) < least[one[0]]
    ]
