"""Format `lux`: streams of LUX scan messages (0x2202); a file is the stream of one LUX."""

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import merge
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.format_choice import readable
from luxloop.scenarios.recordings.sweep import PoseList, Sweep
from luxloop.sensor_model.formats.lux_scan_message import CM_PER_M, LuxMessage
from luxloop.sensor_model.formats.lux_scan_points import points_unit
from luxloop.sensor_model.formats.lux_scan_stream import read_stream
from luxloop.sensor_model.rig.rig import load_unit

if TYPE_CHECKING:
    from luxloop.scenarios.offline.recorded_scans import RecordedRun
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

RECORDING_SUFFIXES = (".lux",)
UNIT = "lux"
"""Unit file with the elevations of the layers, which a message does not hold."""


@dataclass(frozen=True, slots=True)
class LuxStreams:
    """Streams of the LUX of a rig, one file each in the order of the mounts, as a `RecordingSource`."""

    paths: list[Path]

    @property
    def count(self) -> int | None:
        """Not known before the messages are read."""
        return None

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the scans of all units in the order of their times."""
        yield from merge(*(_sweeps(path, unit) for unit, path in enumerate(self.paths)), key=lambda sweep: sweep.time)

    def poses(self, name: str) -> PoseList:
        """Raise an InputError: scan messages hold no poses."""
        raise InputError(f"{self.paths[0]}: {name}: LUX scans hold no poses; leave --odometry and --truth out")


def open_recording(paths: list[Path], _options: "ReadOptions") -> LuxStreams:
    """Take each file as the stream of one unit. See `RecordingFormat`."""
    return LuxStreams(paths)


def export(run: "RecordedRun", folder: Path) -> None:
    """Write a run as streams. See `RunFormat`."""
    from luxloop.scenarios.exchange import lux_export

    lux_export.export(run, folder)


def _sweeps(path: Path, unit: int) -> Iterator[Sweep]:
    elevation_deg = load_unit(UNIT, Path.cwd()).layer_elevation_deg
    with readable(path, "a stream of LUX scans"):
        for message in read_stream(path):
            yield _sweep(message, unit, elevation_deg)


def _sweep(message: LuxMessage, unit: int, elevation_deg: tuple[float, ...]) -> Sweep:
    return Sweep(
        time=message.start_s,
        unit=unit,
        points=points_unit(message, elevation_deg),
        time_offset=message.time_offset,
        ring=message.layer.astype(np.int64),
        echo=message.echo,
        echo_pulse_width=message.width_cm / CM_PER_M,
        flags=(message.flags & 0x0F).astype(np.int64),
    )
