"""Unit names in scenario files."""

from collections.abc import Sequence

ALL_UNITS = "*"


def unit_rows(name: str, unit_names: Sequence[str]) -> list[int]:
    """Return the rows of the units with this name in the rig; all rows for `ALL_UNITS`.

    Raises
    ------
    ValueError
        The name is not a unit of the rig.
    """
    rows = [row for row, unit in enumerate(unit_names) if name in (unit, ALL_UNITS)]
    if not rows:
        raise ValueError(f"unit = {name!r}: not a unit of the rig; name one of: {', '.join(unit_names)}, or *")
    return rows
