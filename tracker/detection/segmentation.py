"""Adaptive segmentation (Zhang 2017): connect points within a radius that grows with range."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats, Ints
from luxloop.compiled import kernel
from luxloop.tracker.detection import point_groups
from luxloop.tracker.detection.point_groups import by_group, by_number
from luxloop.tracker.records import NOT_USED, SegmentedPoints, Segments


@dataclass(frozen=True, slots=True)
class SegmentationConfig:
    """Connection radius of a point: radius_m + radius_per_m * range.

    The beams of a layer are 0.5 degrees apart, the two pairs interleave to 0.25 (IBEO LUX): 0.17 m at 40 m on a
    perpendicular surface, 0.7 m on a side at 15 degrees. Cars in adjacent lanes are 1.4 to 1.7 m apart, queued cars
    2 m. The default radius is 0.7 m at 10 m and 1.3 m at 40 m.
    """

    radius_m: float = 0.5
    """Radius at the ego [m]; must also bridge a side mirror (0.2 m). Lower it if near objects merge."""
    radius_per_m: float = 0.02
    """Growth of the radius with range, dimensionless. Raise it for units of lower resolution, if vehicles are split."""
    points_min: int = 5
    """Smaller segments are dropped: a rectangle has five parameters. Lower it to detect farther, less reliably."""

    def __post_init__(self) -> None:
        if self.radius_m <= 0.0 or self.radius_per_m < 0.0:
            raise ValueError("radius_m must be positive and radius_per_m not negative")
        if self.points_min < 2:
            raise ValueError(f"points_min is {self.points_min}; a segment needs at least 2 points to have a direction")


def segment(points_ego: npt.NDArray[np.floating], keep: Bools, config: SegmentationConfig) -> Segments:
    """Group the kept points (N, 2 or more columns) into connected components of pairs within either point's radius.

    Segments are numbered by their first point. The components equal those of a KD-tree search over all pairs; points
    are first binned into cells no wider than the smallest radius, so that a dense cluster needs no search.
    """
    used = np.flatnonzero(keep)
    first = connect(positions(points_ego, used), config)
    kept = np.bincount(first, minlength=len(used)) >= config.points_min
    label = np.full(len(points_ego), NOT_USED, dtype=np.int64)
    label[used] = np.where(kept, np.cumsum(kept) - 1, NOT_USED)[first]
    return Segments(label=label, count=int(kept.sum()))


def positions(points_ego: npt.NDArray[np.floating], index: Ints) -> Floats:
    """(K, 2) x and y of the points of `index` (K,) [m], for kernels."""
    found: Floats = point_groups.positions(np.asarray(points_ego, dtype=np.float64, order="C"), index)
    return found


def connect(points: Floats, config: SegmentationConfig) -> Ints:
    """(N,) index of the first point of each point's component."""
    if not len(points):
        return np.empty(0, dtype=np.int64)
    return connected(points, config.radius_m, config.radius_per_m)


def sort_by_segment(
    points_ego: npt.NDArray[np.floating],
    segments: Segments,
    *,
    scan_line: Ints | None = None,
    time_offset: npt.NDArray[np.floating] | None = None,
    viewpoints: Floats | None = None,
    truncated: Bools | None = None,
) -> SegmentedPoints:
    """Return the points in segments, for all later stages.

    Parameters
    ----------
    points_ego
        (N, 2 or 3) x, y, and z if known [m].
    scan_line
        (N,) scan line of each point, 0 and up; one line if None.
    time_offset
        (N,) time of each point minus time of the scan [s]; 0 if None.
    viewpoints
        (N, 2) position of the unit of each point [m]; the ego's centre if None.
    truncated
        (N,) mask of points at truncated ends; none if None.
    """
    source, offset = by_group(segments.label, segments.count)
    points = np.asarray(points_ego.take(source, axis=0), dtype=np.float64)
    count = len(source)
    return SegmentedPoints(
        segments=segments,
        offset=offset,
        source=source,
        xy=np.ascontiguousarray(points[:, :2]),
        z=points[:, 2].copy() if points.shape[1] > 2 else np.zeros(count),
        scan_line=np.zeros(count, np.int64) if scan_line is None else np.asarray(scan_line.take(source), np.int64),
        time_offset=np.zeros(count) if time_offset is None else np.asarray(time_offset.take(source), np.float64),
        viewpoint_ego=np.zeros((count, 2)) if viewpoints is None else viewpoints.take(source, axis=0),
        truncated=np.zeros(count, np.bool_) if truncated is None else truncated.take(source),
    )


def regrouped(points: SegmentedPoints, segments: Segments) -> SegmentedPoints:
    """Return the points that are in other `segments` of the same scan, sorted by these."""
    row, offset = by_group(segments.label.take(points.source), segments.count)
    return SegmentedPoints(
        segments=segments,
        offset=offset,
        source=points.source[row],
        xy=points.xy[row],
        z=points.z[row],
        scan_line=points.scan_line[row],
        time_offset=points.time_offset[row],
        viewpoint_ego=points.viewpoint_ego[row],
        truncated=points.truncated[row],
    )


def keep_only(segments: Segments, kept: Bools) -> Segments:
    """Drop the segments that are not `kept` (S,), and renumber the others in the same order."""
    number = np.append(np.where(kept, np.cumsum(kept) - 1, NOT_USED), NOT_USED)
    return Segments(label=number[segments.label], count=int(kept.sum()))


@kernel()
def find_root(parent: Ints, i: int) -> int:
    """Return the representative of the set of i, with path halving."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@kernel()
def unite(parent: Ints, a: int, b: int) -> None:
    """Merge two sets; the lower index represents both."""
    a, b = find_root(parent, a), find_root(parent, b)
    parent[max(a, b)] = min(a, b)


@kernel()
def connect_cells(points: Floats, radius: Floats, parent: Ints, a: int, a_end: int, b: int, b_end: int) -> None:
    """Merge the sets of two cells at the first pair of points within either point's radius."""
    if find_root(parent, a) == find_root(parent, b):
        return
    for i in range(a, a_end):
        for j in range(b, b_end):
            dx, dy = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1]
            reach = max(radius[i], radius[j])
            if dx * dx + dy * dy <= reach * reach:
                unite(parent, i, j)
                return


@kernel()
def cell_starts(column: Ints, row: Ints) -> Ints:
    """(C + 1,) first point of each of the C cells that have points, of points (N,) sorted by cell, and N."""
    start, count = np.zeros(len(column) + 1, np.int64), 1
    for k in range(1, len(column)):
        if column[k] != column[k - 1] or row[k] != row[k - 1]:
            start[count] = k
            count += 1
    start[count] = len(column)
    return start[: count + 1]


@kernel()
def first_of_each(parent: Ints, order: Ints) -> Ints:
    """(N,) lowest index of the points in the set of each point; place k of `parent` (N,) is point order[k]."""
    first = np.full(len(parent), len(parent))
    for k in range(len(parent)):
        parent[k] = find_root(parent, k)
        first[parent[k]] = min(first[parent[k]], order[k])
    found = np.empty(len(parent), np.int64)
    for k in range(len(parent)):
        found[order[k]] = first[parent[k]]
    return found


@kernel()
def connected(points: Floats, radius_m: float, radius_per_m: float) -> Ints:
    """(N,) index of the first point of the component of each point, connected by pairs within either point's radius.

    The radius of points (N, 2) grows with range, see `SegmentationConfig`. They are sorted by grid cells, by column and
    then by row. The diagonal of a cell is at most the smallest radius, so that a cell is one set from the start.
    """
    radius, least, largest = np.empty(len(points)), np.inf, 0.0
    for i in range(len(points)):
        radius[i] = radius_m + radius_per_m * math.sqrt(points[i, 0] ** 2 + points[i, 1] ** 2)
        least, largest = min(least, radius[i]), max(largest, radius[i])
    column, row = np.empty(len(points), np.int64), np.empty(len(points), np.int64)
    pitch = least / math.sqrt(2.0)
    for i in range(len(points)):
        column[i], row[i] = math.floor(points[i, 0] / pitch), math.floor(points[i, 1] / pitch)
    order = by_number(column, by_number(row, np.arange(len(points))))
    parent = united(points[order], radius[order], column[order], row[order], math.ceil(largest / pitch))
    return first_of_each(parent, order)


@kernel()
def united(points: Floats, radius: Floats, column: Ints, row: Ints, window: int) -> Ints:
    """(N,) a member of the set of each point, for points sorted by the `column` (N,) and the `row` (N,) of their cell.

    Columns and rows are overwritten. Pairs within either point's radius are at most `window` cells apart.
    """
    parent, cell = np.empty(len(points), np.int64), cell_starts(column, row)
    cells = len(cell) - 1
    for a in range(cells):
        for k in range(cell[a], cell[a + 1]):
            parent[k] = cell[a]
        column[a], row[a] = column[cell[a]], row[cell[a]]  # from here on those of the cells
    for shift in range(window + 1):
        start = 0
        for a in range(cells):
            first = row[a] + 1 if shift == 0 else row[a] - window
            while start < cells and (
                column[start] < column[a] + shift or (column[start] == column[a] + shift and row[start] < first)
            ):
                start += 1
            b = start
            while b < cells and column[b] == column[a] + shift and row[b] <= row[a] + window:
                connect_cells(points, radius, parent, cell[a], cell[a + 1], cell[b], cell[b + 1])
                b += 1
    return parent
