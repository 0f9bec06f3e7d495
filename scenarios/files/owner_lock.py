"""Names of temporary files and folders, and the lock by which their process owns them.

The lock (`flock`) is on the file or folder itself. The kernel releases it when the process ends, however it ends, and
it holds in all containers of a machine, where process numbers and host names do not tell processes apart. Other
machines that share the volume may not see the lock, so that each removes only what was made under its own kernel.
What was made by another machine, or before a restart of this one, stays until it is deleted by hand. So does
everything on a file system without locks.
"""

import os
import platform
import re
import secrets
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


@cache
def machine() -> str:
    """Return the name of the running kernel: 8 digits that its containers share, or the host name without them."""
    try:
        return _BOOT_ID.read_text(encoding="ascii")[:8]
    except OSError:
        return platform.node()


def beside(path: Path, purpose: str) -> Path:
    """Return an unused name beside `path`, with the machine and the process that make it, and its purpose."""
    return path.with_name(f".{path.name}.{machine()}-{os.getpid()}-{secrets.token_hex(4)}.{purpose}")


def acquire(path: Path) -> int | None:
    """Lock a file or folder; return the descriptor that holds the lock, None if the file system has no locks.

    Raises
    ------
    BlockingIOError
        Another process holds the lock.
    OSError
        The file or folder does not exist, or cannot be opened.
    """
    if sys.platform == "win32":
        return None
    import fcntl

    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        if isinstance(error, BlockingIOError):
            raise
        return None
    return descriptor


def release(descriptor: int | None) -> None:
    """Release a lock of `acquire`; None has no effect."""
    if descriptor is not None:
        os.close(descriptor)


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold the lock of a file or folder, if no other process does."""
    lock = None
    with suppress(OSError):
        lock = acquire(path)
    try:
        yield
    finally:
        release(lock)


def made(path: Path, named: list[Path], make: Callable[[Path], None]) -> tuple[Path, int | None]:
    """Make a temporary file or folder beside `path` and lock it; return its path and its lock.

    Its path is in `named` before it exists, so that a signal at any moment leaves nothing that the caller ignores.
    """
    while True:
        temporary = beside(path, "partial")
        named.append(temporary)
        make(temporary)
        try:
            return temporary, acquire(temporary)
        except (BlockingIOError, FileNotFoundError):  # another process removes it before it is locked
            continue


def abandoned(path: Path, *purposes: str) -> Iterator[tuple[Path, str]]:
    """Yield the temporary files or folders of `path` whose process ended, with their purpose, each while it is locked.

    Raises
    ------
    OSError
        The folder of `path` cannot be listed.
    """
    pattern = re.compile(
        rf"\.{re.escape(path.name)}\.{re.escape(machine())}-\d{{1,9}}-[0-9a-f]{{8}}\.({'|'.join(purposes)})"
    )
    for left in list(path.parent.iterdir()) if path.parent.is_dir() else ():
        if found := pattern.fullmatch(left.name):
            lock = None
            with suppress(OSError):  # its process is alive, or it was removed meanwhile
                lock = acquire(left)
            if lock is None:
                continue
            try:
                yield left, found[1]
            finally:
                release(lock)
