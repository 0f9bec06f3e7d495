"""Parent of a process with code of the user: ends the whole family when the judge closes the control socket or dies.

It runs as a script without luxloop: `python -I -S supervisor.py CONTROL`. The first line on the control socket is the
working folder, to be made, and the command, as JSON; the exit code is its only answer. Orphans of the family become
children of this process, also those in a session of their own (Linux), so that none outlives it.
"""

import ctypes
import json
import os
import resource
import select
import signal
import stat
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

SET_DEATH_SIGNAL, SET_SUBREAPER = 1, 36
"""Options of Linux's prctl."""
FILE_MAX = 4 << 30
"""Largest file that the family may write [bytes]."""


def main(control: int) -> None:
    """Start the command, report its end, and end its family."""
    _prctl(SET_SUBREAPER, 1)
    wake, waker = os.pipe()
    os.set_blocking(waker, False)
    signal.set_wakeup_fd(waker, warn_on_full_buffer=False)
    for number in signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}:  # the family may send any
        with suppress(OSError):
            signal.signal(number, lambda *_: None)
    with open(control, "rb", buffering=0, closefd=False) as lines:
        folder, *arguments = json.loads(lines.readline())
    _reopen_error_output()
    Path(folder).mkdir(0o700)
    try:
        with suppress(OSError):  # no such program: the judge reports that it has ended
            variables = {**os.environ, "TMPDIR": folder}  # so that its temporary files end with it
            device = subprocess.Popen(
                arguments, cwd=folder, env=variables, start_new_session=True, preexec_fn=_restrict
            )
            _serve(device, control, wake)
    finally:
        _end_children()
        remove(folder)


def _serve(device: "subprocess.Popen[bytes]", control: int, wake: int) -> None:
    """Report the end of the device, until the control socket is closed at its other end."""
    for descriptor in (0, 1):
        os.close(descriptor)  # those of the device are the only ones, whose end the judge notices
    while True:
        if control in select.select([control, wake], [], [])[0]:
            break
        os.read(wake, 4096)
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                if ended[0] == device.pid and not os.WIFSTOPPED(ended[1]):  # as one does that lets itself be traced
                    os.write(control, f"{os.waitstatus_to_exitcode(ended[1])}\n".encode())
    device.returncode = 0  # no warning that it may still be running
    with suppress(ProcessLookupError):
        os.killpg(device.pid, signal.SIGKILL)


def _reopen_error_output() -> None:
    """Open standard error anew: its mode, as of a pipe that does not block, would be shared with the judge.

    A regular file has no such mode, and one place to write to.
    """
    with suppress(OSError):  # a socket cannot be opened
        if not stat.S_ISREG(os.fstat(2).st_mode):
            opened = os.open("/proc/self/fd/2", os.O_WRONLY | os.O_NOCTTY)
            os.dup2(opened, 2)
            os.close(opened)


def _restrict() -> None:
    """Limit memory and files of the device, and let it end with this process."""
    _prctl(SET_DEATH_SIGNAL, signal.SIGKILL)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    for kind, most in ((resource.RLIMIT_DATA, memory), (resource.RLIMIT_FSIZE, FILE_MAX), (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(kind)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (least, least))


def _prctl(option: int, value: int) -> None:
    with suppress(OSError, AttributeError):  # another system than Linux
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def _end_children() -> None:
    """Kill all children, and those that their end makes to children, until none is left."""
    while True:
        for process in Path("/proc").glob("[0-9]*"):
            with suppress(OSError):  # it ended meanwhile
                if int((process / "stat").read_bytes().rpartition(b")")[2].split()[1]) == os.getpid():
                    os.kill(int(process.name), signal.SIGKILL)
        try:
            os.waitpid(-1, 0)
        except ChildProcessError:
            return


def remove(folder: str) -> None:
    """Remove the working folder, also if the family has locked it, nested it deeply, or put a link in its place."""
    with suppress(OSError):  # mostly it is empty
        Path(folder).rmdir()
    for command in (["rm", "-rf", folder], ["chmod", "-R", "u+rwx", folder], ["rm", "-rf", folder]):
        if not os.path.lexists(folder):
            return
        with suppress(OSError):
            subprocess.run(command, stderr=subprocess.DEVNULL, check=False)


if __name__ == "__main__":
    main(int(sys.argv[1]))
