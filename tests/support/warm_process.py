"""`python -m MODULE ARGUMENTS` in a process that has imported luxloop and loaded its kernels before.

A start of Python with luxloop takes four seconds of CPU. Here, one process per pytest worker starts once, and forks for
each command: a process of its own, with its own memory, files, exit code and end. Tests of the start itself, of
imports or of the Python path start Python.
"""

import atexit
import gc
import json
import os
import runpy
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from support.paths import TESTS
from support.processes import heed_hangups

HASH_SEED = "2"
"""Of all forked processes."""


class Forked:
    """A forked process, with those methods of `subprocess.Popen` that tests need. One at a time may be running."""

    def __init__(self, server: "subprocess.Popen[bytes]", request: dict) -> None:
        self.args = [request["module"], *request["arguments"]]
        self.returncode: int | None = None
        self._server, self._out, self._err = server, Path(request["out"]), Path(request["err"])
        server.stdin.write(json.dumps(request).encode() + b"\n")
        self.pid = int(server.stdout.readline())

    def poll(self) -> int | None:
        """Return the exit code, or None while the process runs."""
        with suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout: float) -> int:
        """Wait for the end of the process, and return its exit code."""
        if self.returncode is None:
            if not select.select([self._server.stdout], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(self.args, timeout)
            self.returncode = int(self._server.stdout.readline())
        return self.returncode

    def communicate(self, timeout: float) -> tuple[str | None, str]:
        """Wait for the end, and return standard output, unless it went to a device, and standard error."""
        self.wait(timeout)
        return self._out.read_text() if self._out.is_file() else None, self._err.read_text()

    def kill(self) -> None:
        """Kill the process, unless it has ended."""
        if self.poll() is None:
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)


@contextmanager
def started(
    module: str, *arguments: str, cwd: Path | None = None, stdout=None, delete_modules: bool = False
) -> Iterator[Forked]:
    """Run a module as a program in a forked process, in a process group of its own; kill it at the end.

    It inherits the environment without pytest's variables. With `delete_modules`, it ends as an interpreter does.
    """
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    with tempfile.TemporaryDirectory() as folder:
        request = {
            "module": module, "arguments": arguments, "cwd": str(cwd or Path.cwd()),
            "out": str(stdout or Path(folder, "out")), "err": str(Path(folder, "err")),
            "environment": environment, "delete_modules": delete_modules,
        }  # fmt: skip
        process = Forked(_server(), request)
        try:
            yield process
        finally:
            process.kill()
            process.wait(60.0)


def run(module: str, *arguments: str, timeout: float = 300.0, **options):
    """Run a module as a program in a forked process; return its exit code and output as `subprocess.run` does."""
    with started(module, *arguments, **options) as process:
        out, err = process.communicate(timeout)
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def luxloop(*arguments: str, **options):
    """Run `luxloop` in a forked process, see `run`."""
    return run("luxloop", *arguments, **options)


@cache
def _server() -> "subprocess.Popen[bytes]":
    path = os.pathsep.join([str(TESTS), *filter(None, sys.path)])
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": HASH_SEED}
    server = subprocess.Popen(
        [sys.executable, "-m", "support.warm_process"], env=environment, bufsize=0, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )  # fmt: skip
    atexit.register(lambda: (server.stdin.close(), server.wait(), server.stdout.close()))
    return server


def _warm() -> None:
    """Import what commands import, and load the kernels."""
    from support import short_run

    import luxloop.scenarios.execute
    import luxloop.scenarios.interface
    import luxloop.scenarios.oracle.oracle_tracker  # noqa: F401

    short_run.result()
    assert threading.active_count() == 1, "a forked process would miss the other threads"


def _next_request() -> dict | None:
    """Serve requests; return one in each forked process, and None in this one at the end."""
    for line in sys.stdin:
        request = json.loads(line)
        gc.freeze()  # a collection in the fork would copy all pages
        pid = os.fork()
        if pid == 0:
            return request
        print(pid, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)
    return None


def _become(request: dict) -> None:
    """Take the place of `python -m`, in a process group of its own."""
    os.setsid()
    heed_hangups()
    os.chdir(request["cwd"])
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for descriptor, name in ((1, "out"), (2, "err")):
        file = os.open(request[name], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(file, descriptor)
        os.close(file)
    os.environ.clear()
    os.environ.update(request["environment"])
    tempfile.tempdir = None  # that of TMPDIR
    sys.path[0], sys.argv = request["cwd"], [request["module"], *request["arguments"]]
    try:
        runpy.run_module(request["module"], run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else int(error.code is not None)
    if request["delete_modules"]:
        sys.exit(code)
    _leave(code)


def _leave(code: int) -> None:
    """End as an interpreter does, without the second it takes to delete all modules."""
    threading._shutdown()
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except OSError:
        code = 120
    os._exit(code)


if __name__ == "__main__":
    _warm()
    if (request := _next_request()) is not None:
        _become(request)
