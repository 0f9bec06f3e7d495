"""Choice of the reader of a recording, by `--format` or by the names of the files."""

from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.reading_errors import require_bytes
from luxloop.scenarios.recordings.sweep import RecordingSource

FORMATS = {
    "rosbag": (".bag", ".db3", "folder"),
    "mcap": (".mcap",),
    "pcd": (".pcd",),
    "bin": (".bin",),
    "ouster": (".pcap",),
    "lux": (".lux",),
}
"""Suffixes of the files of each format. A folder is a ROS 2 bag. Streams of LUX messages have no common suffix:
`.bin` is KITTI's."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """Options of the readers; each reader uses those that apply to its format."""

    topics: tuple[str, ...] = ()
    """Topics of LIDAR points, one per LIDAR."""
    rate_hz: float = 10.0
    """Sweeps per second, where the files have no times [1/s]."""
    metadata: Path | None = None
    """Metadata of an Ouster sensor; the JSON file beside the capture if None."""


def format_of(paths: list[Path], name: str | None) -> str:
    """Return the format of files: `name`, or that of their suffixes.

    Raises
    ------
    InputError
        The format is not known.
    """
    if name is None:
        return _by_suffix(paths)
    if name not in FORMATS:
        raise InputError(f"--format {name}: should be one of {', '.join(FORMATS)}")
    return name


def open_recording(paths: list[Path], name: str, options: ReadOptions) -> RecordingSource:
    """Open files of the format `name` as one recording.

    Raises
    ------
    InputError
        A file is missing, empty or damaged, or an option does not fit it.
    """
    require_bytes(paths)
    if name == "rosbag":
        from luxloop.scenarios.recordings.formats.ros_bags import open_bags

        return open_bags(paths, list(options.topics))
    if name == "mcap":
        from luxloop.scenarios.recordings.formats.mcap_files import open_mcap

        return open_mcap(paths, list(options.topics))
    if name == "ouster":
        from luxloop.scenarios.recordings.formats.ouster_capture import open_capture

        return open_capture(paths, options.metadata)
    if name == "lux":
        from luxloop.scenarios.recordings.formats.lux_stream import LuxStreams

        return LuxStreams(paths)
    from luxloop.scenarios.recordings.formats.point_files import PointFiles

    return PointFiles.open(paths, name, options.rate_hz)


def _by_suffix(paths: list[Path]) -> str:
    suffix = {"folder" if path.is_dir() else path.suffix.lower() for path in paths}
    found = [name for name, known in FORMATS.items() if suffix <= set(known)]
    if len(found) != 1:
        raise InputError(
            f"{paths[0]}: no format is known by the names of these files; give --format, one of {', '.join(FORMATS)}"
        )
    return found[0]
