"""Claims: comparisons of cells of a block's tables, such as `[fit][HOTA] > [size][HOTA] > 0.7 * [none][HOTA]`."""

import math
import operator
import re
from collections.abc import Iterator

OPERATORS = {"<=": operator.le, ">=": operator.ge, "==": operator.eq, "<": operator.lt, ">": operator.gt}
CELL = re.compile(r"\[(.+?)\]\[(.+)\]")
"""Row and column; a column may have a unit in brackets."""
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


def broken(claims: tuple[str, ...], text: str) -> Iterator[str]:
    """Yield the claims that do not hold in the tables of a text."""
    for claim in claims:
        terms = re.split(r" (<=|>=|==|<|>) ", claim)
        signs = terms[1::2]
        try:
            values = [value(term, text) for term in terms[::2]]
        except (KeyError, ValueError) as error:
            yield f"{claim}: {error}"
            continue
        if not signs or not all(OPERATORS[s](*pair) for s, *pair in zip(signs, values, values[1:], strict=False)):
            yield f"{claim} ({', '.join(map(str, values))})"


def value(term: str, text: str) -> float:
    """Return the product of numbers and of the first numbers of cells."""
    factors = []
    for part in term.split(" * "):
        found = CELL.fullmatch(part)
        shown = NUMBER.search(cell(text, found[1], found[2]) if found else part)
        if not shown:
            raise ValueError(f"{part}: no number")
        factors.append(float(shown[0]))
    return math.prod(factors)


def cell(text: str, row: str, column: str) -> str:
    """Return the cell of the first table that has the row and the column, or raise a KeyError."""
    head: list[str] = []
    for line in text.splitlines():
        cells = [part.strip().strip("*`") for part in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            head = []
        elif not head:
            head = cells
        elif cells[0] == row and column in head:
            return cells[head.index(column)]
    raise KeyError(f"[{row}][{column}]: no such cell")
