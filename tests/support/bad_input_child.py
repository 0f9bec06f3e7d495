"""Runs many cases of one kind of broken input in this process, and prints what went wrong as JSON.

`python -m support.bad_input_child KIND FIRST COUNT`, with tests/ on the path.
"""

import json
import os
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from contextlib import chdir
from pathlib import Path
from typing import Any

from support.bad_input import Case, case, write

CODES = (0, 1, 2, 3, 4, 5)
"""Documented exit codes without those of signals."""
LONGEST_S = 20.0
LONGEST_LINE = 1050


class HangError(BaseException):
    """A command takes too long."""


def run_case(made: Case, folder: Path) -> tuple[int, str]:
    """Run a case in an empty folder; return the exit code and what is wrong with the outcome, if anything."""
    write(made.files, folder)
    before = _files(folder)
    begin = time.monotonic()
    with chdir(folder):
        code, err, fault = _captured(made.command)
    faults = [fault, "" if code in CODES else f"exit code {code}", _bad_line(err, code)]
    seconds = time.monotonic() - begin
    faults.append(f"{seconds:.0f} s" if seconds > LONGEST_S else "")
    after = _files(folder)
    changed = [name for name, content in before.items() if after.get(name) != content and name not in ("out.jsonl",)]
    left = sorted(set(after) - set(before))
    faults.append(f"changed {changed}" if changed and code in (2, 3, 4) else "")
    faults.append(f"left {left[:3]}" if code in (2, 4) and left else "")
    faults.append(f"left {left[:3]}" if any("partial" in name for name in left) else "")
    return code, "; ".join(filter(None, faults))


def _captured(command: list[str]) -> tuple[int, str, str]:
    """Run a command; return exit code, standard error and the traceback of an error that was not caught."""
    from luxloop.scenarios.cli import main

    fault, code = "", -1
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        kept = [os.dup(1), os.dup(2)]
        os.dup2(out.fileno(), 1)
        os.dup2(err.fileno(), 2)
        signal.setitimer(signal.ITIMER_REAL, LONGEST_S, 1.0)
        try:
            code = main(command)
        except HangError:
            fault = "hangs: " + " ".join(traceback.format_exc().split()[-60:])
        except BaseException:
            fault = "".join(traceback.format_exc().splitlines(keepends=True)[-12:])
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            sys.stdout.flush()
            sys.stderr.flush()
            os.dup2(kept[0], 1)
            os.dup2(kept[1], 2)
            for descriptor in kept:
                os.close(descriptor)
        err.seek(0)
        return code, err.read().decode(errors="replace"), fault


def _bad_line(err: str, code: int) -> str:
    """Return what is wrong with standard error."""
    if code == -1:
        return ""
    lines = err.splitlines()
    if code in (2, 3, 4) and len(lines) != 1:
        return f"{len(lines)} lines: {err[-1500:]!r}"
    if code in (0, 1, 5) and len(lines) > 1:
        return f"{len(lines)} lines: {err[-1500:]!r}"
    for line in lines:
        if not (line.startswith("luxloop: error: ") and line.isprintable() and len(line) < LONGEST_LINE):
            return f"line {line!r:.1500}"
    return "traceback" if re.search(r"Traceback|File \"", err) else ""


def _files(folder: Path) -> dict[str, Any]:
    """Return size and time of all files below a folder; None of folders."""
    found = sorted(folder.rglob("*"))
    return {
        str(path.relative_to(folder)): (path.stat().st_size, path.stat().st_mtime_ns) if path.is_file() else None
        for path in found
    }


def main(kind: str, first: int, count: int) -> dict[str, Any]:
    """Run cases; return counts of exit codes, the faults, the longest time and the peak memory."""

    def give_up(*_: object) -> None:
        raise HangError

    signal.signal(signal.SIGALRM, give_up)
    codes: Counter[int] = Counter()
    faults, longest = [], (0.0, -1)
    for number in range(first, first + count):
        made = case(kind, number)
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            code, fault = run_case(made, Path(folder))
        longest = max(longest, (time.monotonic() - begin, number))
        codes[code] += 1
        if fault:
            faults.append(
                {"kind": kind, "number": number, "how": made.how, "command": str(made.command)[:300], "fault": fault}
            )
    peaks = [own_peak_mb(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024]
    return {"kind": kind, "codes": codes, "faults": faults, "longest_s": longest, "peak_mb": peaks}


def own_peak_mb() -> float:
    """Return the peak memory of this process since its program began [MB].

    `ru_maxrss` would include the memory of the parent, of which the process was a copy before.
    """
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return int(next(line.split()[1] for line in lines if line.startswith("VmHWM"))) / 1024


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
