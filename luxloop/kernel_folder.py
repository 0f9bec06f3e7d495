"""Compiled kernels of a wheel, and their folder where neither the installation nor a home can be written."""

import os
import sys
from contextlib import suppress
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
PROCESSOR = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
"""Variables of numba that select the processor of a wheel's kernels: any x86-64 since 2013."""
FLAGS = {
    *("abm", "avx", "avx2", "bmi1", "bmi2", "cx16", "f16c", "fma", "lahf_lm", "movbe", "popcnt", "sse4_1", "sse4_2"),
    *("ssse3", "xsave"),
}
"""Its flags in /proc/cpuinfo."""
SHIPPED = f"kernels-{sys.implementation.cache_tag}.txt"
"""File of a wheel with kernels of this Python: the version of numba that compiled them."""


def use_shipped(package: Path) -> None:
    """Let numba compile for the processor of the wheel's kernels, if they can be used: it finds them, then.

    numba looks beside the sources only if it can write there, and in no other folder than that of `VARIABLE`.
    """
    if "numba" in sys.modules or os.environ.keys() & {VARIABLE, *PROCESSOR} or not os.access(package, os.W_OK):
        return
    with suppress(OSError):  # an installation from source has no such file
        if (package / SHIPPED).read_text(encoding="utf-8") == _numba_version() and _flags() >= FLAGS:
            os.environ.update(PROCESSOR)


def _numba_version() -> str:
    from importlib.metadata import version  # takes longer than the rest of `import luxloop`

    return version("numba")


def _flags() -> set[str]:
    """Return the flags of the first processor of this machine; none where Linux does not list them."""
    with open("/proc/cpuinfo", encoding="utf-8") as lines:  # noqa: PTH123
        return next((set(line.split()) for line in lines if line.startswith("flags")), set())


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
