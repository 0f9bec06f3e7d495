"""Sweeps to scans: mounts, layers, scale, time and ego pose."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Floats, Ints
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.recordings.ego_mount import EgoMount, levelled
from luxloop.scenarios.recordings.import_options import ImportOptions
from luxloop.scenarios.recordings.layer_cut import HeightCut, Rings
from luxloop.scenarios.recordings.pose_track import PoseTrack
from luxloop.scenarios.recordings.sweep import Sweep
from luxloop.tracker.scan import Scan

LAYERS_MAX = 256
"""A layer is a byte."""


@dataclass(slots=True)
class Skipped:
    """Numbers of sweeps that are not in the recorded scans, by reason."""

    empty: int = 0
    """Without a point after the cuts."""
    not_later: int = 0
    """Not later than the sweep before: repeated or out of order."""
    without_pose: int = 0
    """Outside the times of the ego's poses."""
    before_first: int = 0
    """Of further LIDARs, before the first sweep of the first one."""


class EgoScans:
    """Scans in the ego frame.

    A scan begins with a sweep of the first LIDAR and takes those of the others until its next one. Its time is the
    middle of the first LIDAR's sweep.

    Parameters
    ----------
    options
        Options of the import.
    ego
        Scaled poses of the ego; None for an ego that stands.
    """

    def __init__(self, options: ImportOptions, ego: PoseTrack | None) -> None:
        self._options, self._ego = options, ego
        self._mounts: dict[int, EgoMount] = {}
        self._rings: dict[int, Rings] = {}
        self._first_pose: Floats | None = None
        self.skipped = Skipped()
        self.time_of: dict[int, float] = {}
        """Scaled time of each scan on the clock of the recording [s], by the number of its sweep of the first LIDAR."""
        self._without_pose_s: list[float] = []

    @property
    def first_pose(self) -> Floats:
        """(3,) scaled pose of the ego at the first scan: the odometry frame in the frame of the poses."""
        return np.zeros(3) if self._first_pose is None else self._first_pose

    @property
    def mounts(self) -> list[EgoMount]:
        """Mounts of the LIDARs that gave points, levelled if asked for."""
        return [self._mounts[unit] for unit in sorted(self._mounts)]

    @property
    def clocks(self) -> str:
        """Times of the sweeps without a pose, and of the poses; empty if all sweeps have one."""
        if not self._without_pose_s or self._ego is None:
            return ""
        (first, last), (begin, end) = (min(self._without_pose_s), max(self._without_pose_s)), self._ego.span
        return f"sweeps without a pose are from {first:.1f} to {last:.1f} s, poses from {begin:.1f} to {end:.1f} s"

    def of(self, sweeps: Iterable[Sweep]) -> Iterator[tuple[float, Scan]]:
        """Yield the scaled time on the recording's clock [s], and the scan, whose own time starts from 0."""
        start = None
        for number, group in enumerate(self._groups(sweeps)):
            group = [self._timed(sweep) for sweep in group]
            parts = [self._placed(sweep) for sweep in group]
            first = group[0]
            middle = first.time + (0.5 * (first.time_offset.min() + first.time_offset.max()) if len(first) else 0.0)
            time = self._options.scale_time * middle
            pose = self._pose(time)
            if pose is None:
                self.skipped.without_pose += 1
                self._without_pose_s.append(time)
            elif start is not None and time <= start[1]:
                self.skipped.not_later += 1
            elif not any(len(points) for points, _, _ in parts):
                self.skipped.empty += 1
            else:
                start = (time if start is None else start[0], time)
                self.time_of[number] = time
                yield time, self._scan(time - start[0], middle, pose, parts)

    def _groups(self, sweeps: Iterable[Sweep]) -> Iterator[list[Sweep]]:
        group: list[Sweep] = []
        for sweep in sweeps:
            if sweep.unit == 0:
                if group:
                    yield group
                group = [sweep]
            elif group:
                group.append(sweep)
            else:
                self.skipped.before_first += 1
        if group:
            yield group

    def _timed(self, sweep: Sweep) -> Sweep:
        """Return a sweep whose points take `sweep_time_s` from the first to the last, if that is given."""
        duration = self._options.sweep_time_s
        if duration is None or not len(sweep):
            return sweep
        recorded = sweep.time_offset - sweep.time_offset.min()
        order = np.linspace(0.0, 1.0, len(sweep))
        return replace(sweep, time_offset=duration * (recorded / recorded.max() if recorded.any() else order))

    def _placed(self, sweep: Sweep) -> tuple[Floats, Sweep, Ints]:
        """Return points in the ego frame (N, 3) [m, not scaled], their sweep, and their layers (N,)."""
        options = self._options
        if sweep.unit not in self._mounts:
            if sweep.unit >= len(options.mounts):
                raise InputError(
                    f"the recording has more LIDARs than the {len(options.mounts)} mounts; add a --mount each"
                )
            mount = options.mounts[sweep.unit]
            self._mounts[sweep.unit] = levelled(sweep.points, mount) if options.level else mount
            self._rings[sweep.unit] = Rings.of(sweep)
        points = self._mounts[sweep.unit].to_ego(sweep.points)
        layer = self._layers(sweep, points)
        keep = layer >= 0
        if options.heights_m is not None:
            keep &= (points[:, 2] >= options.heights_m[0]) & (points[:, 2] <= options.heights_m[1])
        return points[keep], sweep.subset(keep), layer[keep]

    def _layers(self, sweep: Sweep, points_ego: Floats) -> Ints:
        cut, rings = self._options.cut, self._rings[sweep.unit]
        if cut is None:
            return np.minimum(rings.layers(sweep), LAYERS_MAX - 1)
        return cut.layers(sweep, points_ego[:, 2]) if isinstance(cut, HeightCut) else cut.layers(sweep, rings)

    def _pose(self, time: float) -> Floats | None:
        """Return the ego's pose (3,) in the odometry frame at a scaled time [s], or None without one."""
        if self._ego is None:
            return np.zeros(3)
        pose = self._ego.at(time)
        if pose is None:
            return None
        if self._first_pose is None:
            self._first_pose = pose
        relative: Floats = into_frame(pose[None], self._first_pose)[0]
        return relative

    def _scan(self, time: float, middle: float, pose: Floats, parts: list[tuple[Floats, Sweep, Ints]]) -> Scan:
        length, factor = self._options.scale_length, self._options.scale_time
        sweeps = [sweep for _, sweep, _ in parts]
        width = [_or_zero(sweep.echo_pulse_width, sweep) * length for sweep in sweeps]
        try:
            with np.errstate(over="ignore"):  # `RecordingWriter.add` refuses them
                return Scan.from_points(
                    time,
                    length * np.concatenate([points for points, _, _ in parts]),
                    pose,
                    time_offset=factor * np.concatenate([sweep.time - middle + sweep.time_offset for sweep in sweeps]),
                    unit=np.concatenate([np.full(len(sweep), sweep.unit) for sweep in sweeps]),
                    layer=np.concatenate([layer for _, _, layer in parts]),
                    echo=np.concatenate([_or_zero(sweep.echo, sweep) for sweep in sweeps]),
                    echo_pulse_width=np.concatenate(width),
                    flags=np.concatenate([_or_zero(sweep.flags, sweep) for sweep in sweeps]),
                )
        except ValueError as error:
            raise InputError(f"the sweep at {middle:.3f} s: {error}; the recording is damaged") from error


def _or_zero(values: npt.NDArray[Any] | None, sweep: Sweep) -> npt.NDArray[Any]:
    return np.zeros(len(sweep)) if values is None else values
