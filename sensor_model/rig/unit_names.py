"""Units as scenario files name them."""

from collections.abc import Sequence

ALL_UNITS = "*"


def rows_of(name: str, unit_names: Sequence[str]) -> list[int]:
    """Rows of the units of this name in the rig: one, or for `ALL_UNITS` all.

    Raises
    ------
    ValueError
        The rig has no such unit.
    """
    rows = [row for row, unit in enumerate(unit_names) if name in (unit, ALL_UNITS)]
    if not rows:
        raise ValueError(f"unit = {name!r}: the rig has no such unit; name one of: {', '.join(unit_names)}, or *")
    return rows
