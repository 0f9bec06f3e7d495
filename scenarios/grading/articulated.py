"""Vehicles with joints as a box per section: while one is bent, one rectangle does not describe it.

Sections are those of `luxloop.sim.sections`: trailer and tractor, the parts of a bus, the cars of a tram or train.
"""

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.grading.plane_geometry import turned
from luxloop.sim.sections import section_moves, sections
from luxloop.sim.world import JOINTS, Kind

Kinds = npt.NDArray[np.uint8]
"""`Kind` of each vehicle."""
ARTICULATION = ("articulation_rad", *(f"articulation_{joint}_rad" for joint in range(2, JOINTS + 1)))
"""Columns of tables with the angles at the joints, from the front."""


def section_boxes(pose: Floats, size: Floats, angles: Floats, kind: Kinds) -> tuple[Ints, Ints, Floats, Floats]:
    """Return vehicle row, section, pose (M, 3) and size of each section of N vehicles with joints.

    The section that defines the pose of its vehicle comes first, for all vehicles; then the others from the rear, so
    that the front of each vehicle is last.

    Parameters
    ----------
    pose
        (N, 3) poses of the straight vehicles' boxes, in any frame [m, m, rad].
    size
        (N, 2) or (N, 3) sizes of these boxes, length first [m].
    angles
        (N, JOINTS) see `luxloop.sim.world.Actors.joint_angles` [rad].
    kind
        (N,) `Kind`.
    """
    straight = sections(kind, size[:, 0])
    middle, _, front, rear = straight
    turn, pivot, moved = section_moves(straight, size[:, 0], angles)
    others = [(row, section) for section in range(JOINTS, -1, -1) for row in np.flatnonzero(middle != section)]
    pairs = [*enumerate(middle), *(pair for pair in others if rear[pair] > front[pair])]
    row, section = np.array(pairs, np.int64).reshape(-1, 2).T
    at = row, section
    centre = np.zeros((len(row), 2))
    centre[:, 0] = 0.5 * size[row, 0] - 0.5 * (front[at] + rear[at]) - pivot[at]
    centre = moved[at] + turned(centre, turn[at])
    place = pose[row, :2] + turned(centre, pose[row, 2])
    boxes = np.column_stack([rear[at] - front[at], size[row, 1:]])
    return row, section, np.column_stack([place, pose[row, 2] + turn[at]]), boxes


def parts(pose: Floats, size: Floats, angles: Floats, kind: Kinds) -> tuple[Ints, Floats, Floats]:
    """Return boxes that show N vehicles: vehicle row, pose and size of each.

    The first N are the vehicles, bent ones as the section that defines the pose, such as a trailer; the other sections
    of the bent ones follow. Parameters as for `section_boxes`.
    """
    bent = np.flatnonzero(angles.any(axis=1))
    row, _, part_pose, part_size = section_boxes(pose[bent], size[bent], angles[bent], kind[bent])
    poses, sizes, count = pose.copy(), size.copy(), len(bent)
    poses[bent], sizes[bent] = part_pose[:count], part_size[:count]
    rows = np.append(np.arange(len(pose)), bent[row[count:]])
    return rows, np.vstack([poses, part_pose[count:]]), np.vstack([sizes, part_size[count:]])


def kinds_of(names: Iterable[str]) -> Kinds:
    """Return the `Kind` of each name in a table of the truth."""
    return np.array([Kind[name.upper()] for name in names], np.uint8)


def angles_of(table: pd.DataFrame) -> Floats:
    """Return the angles (N, JOINTS) at the joints [rad] in a table; those of joints without a column are 0."""
    return np.asarray(table.reindex(columns=ARTICULATION, fill_value=0.0).to_numpy(np.float64))
