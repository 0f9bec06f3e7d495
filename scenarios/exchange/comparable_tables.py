"""Tables of the two files of a grading that can be compared: in the same axes, about the ego, of some classes."""

import numpy as np

from luxloop.scenarios.arrays import Bools
from luxloop.scenarios.errors import TracksError
from luxloop.scenarios.exchange.box_table import ANY_AXES, EGO_AXES, BoxTable


def in_common_axes(truth: list[BoxTable], tracks: list[BoxTable]) -> tuple[BoxTable, BoxTable]:
    """Return the first tables of both files in the same frame of reference.

    Raises
    ------
    TracksError
        There is none.
    """
    pairs = [(a, b) for a in truth for b in tracks if ANY_AXES in (a.axes, b.axes) or a.axes == b.axes]
    if not pairs:
        there, here = (" and ".join(table.axes for table in tables) for tables in (truth, tracks))
        raise TracksError(
            f"{tracks[0].source}: its positions are in {here} axes, those of {truth[0].source} in {there} axes; "
            "give both files in the same frame of reference"
        )
    return min(pairs, key=lambda pair: pair[0].axes != pair[1].axes)


def about_the_ego(tables: list[BoxTable]) -> list[BoxTable]:
    """Return the tables whose axes start at the ego.

    Raises
    ------
    TracksError
        There is none, so the distances from the ego are unknown.
    """
    found = [table for table in tables if table.axes in EGO_AXES]
    if not found:
        axes = " and ".join(table.axes or "unnamed" for table in tables)
        raise TracksError(
            f"{tables[0].source}: its positions are in {axes} axes, so distances from the ego are unknown; "
            "give positions in the ego frame (x_ego_m), or --points-min instead of --range-max"
        )
    return found


def of_classes(truth: BoxTable, tracks: BoxTable, classes: list[str]) -> tuple[BoxTable, BoxTable]:
    """Return the boxes of some classes; tracks without classes are all kept.

    Raises
    ------
    TracksError
        The truth has no classes, or not these.
    """
    wanted = [name.strip().lower() for name in classes]
    if truth.kind is None:
        raise TracksError(f"{truth.source}: has no classes; leave --classes out")
    known = sorted(set(truth.kind.tolist()))
    missing = [name for name in wanted if name not in known]
    if missing:
        raise TracksError(f"{truth.source}: --classes {missing[0]}: not in the file; it has {', '.join(known)[:300]}")
    kept = [table if table.kind is None else table.select(_is_among(table, wanted)) for table in (truth, tracks)]
    return kept[0], kept[1]


def _is_among(table: BoxTable, names: list[str]) -> Bools:
    found: Bools = np.isin(table.kind, names)  # type: ignore[arg-type]
    return found
