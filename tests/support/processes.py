"""State of other processes, from /proc."""

import hashlib
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path


def children_of(parent: int) -> list[int]:
    """Return the ids of the child processes of a process."""
    pids = [int(path.name) for path in Path("/proc").glob("[0-9]*")]
    return [pid for pid in pids if (state := _stat(pid)) and int(state[1]) == parent]


def is_dead(pid: int) -> bool:
    """Return True if a process has ended (including zombies, which wait for their parent)."""
    state = _stat(pid)
    return not state or state[0] == "Z"


def stop(pid: int) -> None:
    """Stop a process, and wait until it has stopped or ended."""
    os.kill(pid, signal.SIGSTOP)
    until(lambda: not (state := _stat(pid)) or state[0] in "TZ", pause_s=0.001)


def until(condition: Callable[[], bool], patience_s: float = 60.0, pause_s: float = 0.05) -> None:
    """Wait until a condition is true."""
    deadline = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline, "timeout: the condition is still false"
        time.sleep(pause_s)


def _stat(pid: int) -> list[str]:
    """Return the fields of /proc/PID/stat from the state on; empty if the process has ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return []


def files_of(folder: Path) -> dict[str, str]:
    """Return the hash of every file below a folder."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def heed_hangups() -> None:
    """Restore the default action of SIGHUP in a child, before its program begins: `nohup` lets it be ignored."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
