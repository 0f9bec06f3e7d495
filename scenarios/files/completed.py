"""Results that are whole on disk, so that the message of a late Ctrl-C can name them."""

from pathlib import Path

_announced: list[tuple[Path, int]] = []
"""Final paths, with the inode of the temporary file or folder that is renamed to each."""


def announce(path: Path, temporary: Path) -> None:
    """Note that `temporary` is whole and about to be renamed to `path`."""
    _announced.append((path, temporary.stat().st_ino))


def forget() -> None:
    """Forget the results of an earlier command of this process."""
    _announced.clear()


def listed() -> list[Path]:
    """Return the paths whose rename took place, in its order."""
    return [path for path, inode in _announced if _inode(path) == inode]


def _inode(path: Path) -> int | None:
    try:
        return path.stat().st_ino
    except OSError:
        return None
