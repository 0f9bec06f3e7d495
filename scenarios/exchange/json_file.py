"""Reading of JSON files, and checks of their values; every error is one line with the place and the remedy."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import TracksError

Row = dict[str, Any]


def read_json(path: Path) -> Any:
    """Return the content of a file.

    Raises
    ------
    TracksError
        The file cannot be read, or is no JSON.
    """
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise TracksError(f"{path}: cannot be read ({reason}); give a nuScenes file in JSON") from error


def value(path: Path, place: str, row: Any, key: str) -> Any:
    """Return a value of a row.

    Raises
    ------
    TracksError
        The row is no object, or lacks the key.
    """
    if not isinstance(row, dict) or key not in row:
        raise TracksError(f"{path}: {place}: no key {key}; add it; see docs/formats.md")
    return row[key]


def text(path: Path, place: str, row: Any, key: str) -> str:
    """Return a text of a row; an integer is an id, too.

    Raises
    ------
    TracksError
        The value is neither.
    """
    found = value(path, place, row, key)
    if isinstance(found, bool) or not isinstance(found, str | int):
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a text")
    return str(found)


def number_list(path: Path, place: str, row: Any, key: str, count: int) -> Floats:
    """Return a list of `count` numbers of a row, which may be NaN.

    Raises
    ------
    TracksError
        The value is no such list.
    """
    found = value(path, place, row, key)
    good = isinstance(found, list) and len(found) == count and all(_is_number(item) for item in found)
    if not good:
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a list of {count} numbers")
    return np.array(found, dtype=np.float64)


def number(path: Path, place: str, row: Any, key: str) -> float:
    """Return a number of a row.

    Raises
    ------
    TracksError
        The value is no number.
    """
    found = value(path, place, row, key)
    if not _is_number(found):
        raise TracksError(f"{path}: {place}, {key}: {str(found)[:60]}: should be a number")
    return float(found)


def _is_number(found: Any) -> bool:
    """Return True for a number of a usual size; integers of any length are valid JSON, and too large for a float."""
    return isinstance(found, int | float) and not isinstance(found, bool) and not abs(found) > 1e300
