"""Choice of the reader of a recording, by `--format` or by the names of the files, and errors of damaged files."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from luxloop.plugins import formats_that
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.files.input_file import require_plain
from luxloop.scenarios.files.option_values import format_named
from luxloop.scenarios.recordings.sweep import RecordingSource


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """Options of the readers; each reader uses those that apply to its format."""

    topics: tuple[str, ...] = ()
    """Topics of LIDAR points, one per LIDAR."""
    rate_hz: float = 10.0
    """Sweeps per second, where the files have no times [1/s]."""
    metadata: Path | None = None
    """Metadata of an Ouster sensor; the JSON file beside the capture if None."""
    by_log: bool = False
    """True if messages have the times at which they were logged, and not those of their stamps."""
    time_unit_s: float | None = None
    """Unit of the times of points [s]; found from their type and from the duration of a sweep if None."""
    scene: str | None = None
    """Scene, sequence or log of a data set; its only one if None."""


class RecordingFormat(Protocol):
    """Format of recordings of sensors, a plug-in of the group `luxloop.formats`."""

    RECORDING_SUFFIXES: tuple[str, ...]
    """Endings of the names of its files, such as ".bag", and "folder" if a folder is one."""

    def open_recording(self, paths: list[Path], options: ReadOptions) -> RecordingSource:
        """Open files, which exist and are not empty, as one recording.

        Raises
        ------
        InputError
            A file is damaged or of another format, or an option does not fit it.
        """
        ...


def format_of(paths: list[Path], name: str | None) -> RecordingFormat:
    """Return the format of files: `name`, or that of their suffixes.

    Raises
    ------
    InputError
        The format is not known, or its plug-in cannot be used.
    """
    found: RecordingFormat = format_named("--format", name or _by_suffix(paths), "open_recording")
    return found


def open_recording(paths: list[Path], chosen: RecordingFormat, options: ReadOptions) -> RecordingSource:
    """Open files as one recording.

    Raises
    ------
    InputError
        A file is missing, empty or damaged, or an option does not fit it.
    """
    require_bytes(paths)
    return chosen.open_recording(paths, options)


def _by_suffix(paths: list[Path]) -> str:
    formats: dict[str, RecordingFormat] = formats_that("open_recording")
    suffix = {"folder" if path.is_dir() else path.suffix.lower() for path in paths}
    found = [name for name, known in formats.items() if suffix <= set(known.RECORDING_SUFFIXES)]
    if len(found) != 1:
        raise InputError(
            f"{paths[0]}: {'several formats are' if found else 'no format is'} known by the names of these files; give "
            f"--format, one of {', '.join(found or formats)}"
        )
    return found[0]


@contextmanager
def readable(path: Path, what: str) -> Iterator[None]:
    """Turn any error of a parser into an InputError of one line that names file and format.

    Parsers of binary files meet arbitrary bytes, and raise the errors of their libraries: struct.error, KeyError,
    AssertionError, decompression errors.

    Raises
    ------
    InputError
        The file cannot be read as `what`.
    """
    try:
        yield
    except MemoryError:
        raise
    except InputError as error:
        if str(path) in str(error):
            raise
        raise type(error)(f"{path}: {error}") from error
    except Exception as error:
        reason = " ".join(str(error).split()).removeprefix(f"{path}: ") or type(error).__name__
        raise InputError(
            f"{path}: not readable as {what} ({reason}); it is damaged, truncated or of another format, see --format"
        ) from error


def require_bytes(paths: list[Path]) -> None:
    """Raise an InputError for a path that does not exist, and for an empty file, a device or a pipe."""
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such file; give the path of a recording")
        require_plain(path)
        if path.is_file() and path.stat().st_size == 0:
            raise InputError(f"{path}: is empty; give a complete recording")


def only_folder(paths: list[Path]) -> Path:
    """Return the folder of a data set; raise an InputError for files and for several folders."""
    if len(paths) > 1 or not paths[0].is_dir():
        raise InputError(f"{paths[-1]}: give the one folder of the data set, and --scene to choose from it")
    return paths[0]
