"""Folder of compiled kernels where neither the installation nor a home can be written, as in many containers."""

import os
from contextlib import suppress
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"


def choose(package: Path) -> None:
    """Name a folder of this user in the temporary folder, if numba would find no folder beside the sources or at home.

    Processes that this one starts use it, too. The files in it are executed, so that it must belong to this user alone.
    """
    # Path.expanduser raises an error for a user without a home, as containers have them.
    caches = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))  # noqa: PTH111
    if os.environ.get(VARIABLE) or os.access(package, os.W_OK) or _can_be_made(caches):
        return
    import tempfile  # takes longer than the rest of `import luxloop`

    with suppress(OSError):  # then numba says that it has no folder
        folder = Path(tempfile.gettempdir()) / f"luxloop-kernels-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
        if folder.is_dir() and not folder.is_symlink() and status.st_uid == os.getuid() and not status.st_mode & 0o077:
            os.environ[VARIABLE] = str(folder)


def _can_be_made(folder: Path) -> bool:
    """Return True if a folder, or the nearest one above it that exists, can be written."""
    if not folder.is_absolute():
        return False
    # Path.exists raises an error below a folder that cannot be entered.
    there = next((one for one in (folder, *folder.parents) if os.path.exists(one)), folder)  # noqa: PTH110
    return there.is_dir() and os.access(there, os.W_OK)
