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
from functools import cache
from pathlib import Path

from support.paths import TESTS


def run(module: str, *arguments: str, cwd: Path | None = None, timeout: float = 300.0, stdout=None):
    """Run a module as a program in a forked process; return its exit code and output as `subprocess.run` does."""
    with tempfile.TemporaryDirectory() as folder:
        out, err = Path(folder, "out"), Path(folder, "err")
        request = {
            "module": module, "arguments": arguments, "cwd": str(cwd or Path.cwd()), "out": str(stdout or out),
            "err": str(err), "environment": dict(os.environ),
        }  # fmt: skip
        code = _code(_server(), request, timeout)
        return subprocess.CompletedProcess(
            [module, *arguments], code, out.read_text() if out.exists() else None, err.read_text()
        )


def luxloop(*arguments: str, **options):
    """Run `luxloop` in a forked process, see `run`."""
    return run("scenarios", *arguments, **options)


def _code(server: "subprocess.Popen[str]", request: dict, timeout: float) -> int:
    server.stdin.write(json.dumps(request) + "\n")
    server.stdin.flush()
    pid = int(server.stdout.readline())
    if not select.select([server.stdout], [], [], timeout)[0]:
        os.kill(pid, signal.SIGKILL)
        server.stdout.readline()
        raise subprocess.TimeoutExpired([request["module"], *request["arguments"]], timeout)
    return int(server.stdout.readline())


@cache
def _server() -> "subprocess.Popen[str]":
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(TESTS), *filter(None, sys.path)])}
    server = subprocess.Popen(
        [sys.executable, "-m", "support.warm_process"], env=environment, text=True, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )  # fmt: skip
    atexit.register(lambda: (server.stdin.close(), server.wait(), server.stdout.close()))
    return server


def _warm() -> None:
    """Import what commands import, and load the kernels."""
    from support import short_run

    import scenarios.commands.run_request
    import scenarios.grading.grader  # noqa: F401

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
    """Take the place of `python -m`."""
    os.chdir(request["cwd"])
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for descriptor, name in ((1, "out"), (2, "err")):
        file = os.open(request[name], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
        os.dup2(file, descriptor)
        os.close(file)
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.path[0], sys.argv = request["cwd"], [request["module"], *request["arguments"]]
    try:
        runpy.run_module(request["module"], run_name="__main__", alter_sys=True)
        code = 0
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else int(error.code is not None)
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
