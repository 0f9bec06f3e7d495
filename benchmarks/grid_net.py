"""Nets of grids of any size, made of the parts of a small one.

`block.net.xml.xz` is a grid of five columns that was built with SUMO 1.28 by

    netgenerate --grid --grid.number 5 --grid.length 150 --no-turnarounds --output-file block.net.xml

The comment at its head and empty lines are removed, and the file is compressed with `xz -9`. Its outer two columns and
rows become those of the larger grid, and its middle ones are repeated. The result equals netgenerate's net of that
size, except for the right of way between equal roads, which netgenerate settles by their names.
"""

import lzma
import re
import string
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

BLOCK = Path(__file__).parent / "block.net.xml.xz"
LENGTH_M = 150.0
"""[m] Between two junctions."""
LETTERS = string.ascii_uppercase + string.ascii_lowercase
"""Names of columns, in netgenerate's order, which limit their number."""

Place = tuple[int, int]
"""Column and row of a junction."""

_NAME = re.compile(r"([A-E])([0-4])")


def write_grid(file: Path, columns: int) -> None:
    """Write the net of a grid with as many rows as columns, 5 to 52."""
    parts = _parts(ET.fromstring(lzma.decompress(BLOCK.read_bytes())))
    places = [(column, row) for column in range(columns) for row in range(columns)]
    side = LENGTH_M * (columns - 1)
    with file.open("w") as stream:
        stream.write('<net version="1.20" junctionCornerDetail="5" limitTurnSpeed="5.50">\n')
        bounds = f"0.00,0.00,{side:.2f},{side:.2f}"
        stream.write(f'<location netOffset="0.00,0.00" convBoundary="{bounds}" origBoundary="{bounds}" ')
        stream.write('projParameter="!"/>\n')
        for part in parts:
            for place in places:
                stream.writelines(_placed(part, place, columns))
        stream.write("</net>\n")


def junction(place: Place) -> str:
    """Return the name of a junction."""
    return f"{LETTERS[place[0]]}{place[1]}"


def edge(begin: Place, end: Place) -> str:
    """Return the name of the edge between two junctions."""
    return junction(begin) + junction(end)


def neighbours(place: Place, columns: int) -> list[Place]:
    """Return the adjacent junctions: east, north, west, south, as far as they exist."""
    ways = ((1, 0), (0, 1), (-1, 0), (0, -1))
    around = [(place[0] + east, place[1] + north) for east, north in ways]
    return [other for other in around if min(other) >= 0 and max(other) < columns]


def _parts(block: ET.Element) -> list[dict[Place, list[ET.Element]]]:
    """Return internal edges, edges, junctions and connections of the block, by the junction that they belong to."""
    parts: list[dict[Place, list[ET.Element]]] = [defaultdict(list) for _ in range(4)]
    for element in block:
        name = element.get("id") or element.get("from") or ""
        names = [(ord(column) - ord("A"), int(row)) for column, row in _NAME.findall(name)]
        match element.tag:
            case "edge":
                parts[not name.startswith(":")][names[0]].append(element)
            case "junction":
                parts[2][names[0]].append(element)
            case "connection":
                parts[3][names[-1]].append(element)
    return parts


def _placed(part: dict[Place, list[ET.Element]], place: Place, columns: int) -> Iterator[str]:
    """Yield the elements of a junction of the grid, as text."""
    model = _model(place[0], columns), _model(place[1], columns)
    shift = place[0] - model[0], place[1] - model[1]

    def renamed(match: re.Match[str]) -> str:
        column, row = match.groups()
        return junction((ord(column) - ord("A") + shift[0], int(row) + shift[1]))

    def text(element: ET.Element) -> str:
        values = ((key, _moved(key, value, shift) or _NAME.sub(renamed, value)) for key, value in element.items())
        head = f"<{element.tag} " + " ".join(f'{key}="{value}"' for key, value in values)
        return f"{head}>{''.join(map(text, element))}</{element.tag}>"

    for element in part[model]:
        yield text(element) + "\n"


def _model(index: int, columns: int) -> int:
    """Return the column or row of the block that has the shape of one of the grid."""
    return min(index, 2) + max(index - (columns - 1) + 2, 0)


def _moved(key: str, value: str, shift: Place) -> str:
    """Return a coordinate or shape moved by columns and rows; empty for other attributes."""
    east, north = LENGTH_M * shift[0], LENGTH_M * shift[1]
    match key:
        case "x":
            return f"{float(value) + east:.2f}"
        case "y":
            return f"{float(value) + north:.2f}"
        case "shape":
            points = (point.split(",") for point in value.split())
            return " ".join(f"{float(x) + east:.2f},{float(y) + north:.2f}" for x, y in points)
    return ""
