"""Other processes, as the kernel tells of them."""

import time
from collections.abc import Callable
from pathlib import Path


def children_of(parent: int) -> list[int]:
    """Numbers of the processes that a process has started."""
    pids = [int(path.name) for path in Path("/proc").glob("[0-9]*")]
    return [pid for pid in pids if (state := _stat(pid)) and int(state[1]) == parent]


def is_dead(pid: int) -> bool:
    """Whether a process is gone, but for a parent that may still ask how it ended."""
    state = _stat(pid)
    return not state or state[0] == "Z"


def until(condition: Callable[[], bool], patience_s: float = 60.0, pause_s: float = 0.05) -> None:
    """Wait for something to come true."""
    end = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(pause_s)


def _stat(pid: int) -> list[str]:
    """State, parent and so on; nothing of a process that is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return []
