"""Plug-in of pytest that runs scenario files: `pytest my-scenarios -n 2 --junitxml=results.xml`.

Every `.toml` file with a table `[traffic]` is a test, named after the folder of its run. pytest loads this module
wherever luxloop is installed, so slow packages are imported only when a scenario runs.
"""

import argparse
import re
import shlex
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from luxloop.scenarios.commands.error_messages import request
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.exit_codes import ExitCode, explain
from luxloop.scenarios.files import input_file

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result

FOLDER = "folder"
"""User property of a test with the folder of its run."""

_TRAFFIC = re.compile(rb"^\s*\[{0,2}\s*traffic\b", re.MULTILINE)
"""Recognises a scenario among TOML files without parsing it: an invalid scenario must fail, not be skipped."""

DEFAULT_SEED = 1
"""As in `luxloop.scenarios.files.scenario`, which is slow to import."""
SHIPPED = "luxloop.tracker.tracker:Tracker"
"""As in `luxloop.scenarios.files.expect`, which is slow to import."""

NOTHING_OBSERVED = "no expectation has an observation"


class FailedRunError(Exception):
    """An expectation without `known_failure` failed, or the run ended early."""


class KnownFailuresError(Exception):
    """Only expectations with `known_failure` failed."""


RESULTS = (FailedRunError, KnownFailuresError)
"""Outcomes of a run."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of luxloop, similar to those of `luxloop run`."""
    group = parser.getgroup("luxloop", "scenarios as tests")
    group.addoption("--luxloop-tracker", metavar="MODULE:NAME", help="the tracker, or FILE.py:NAME [the shipped one]")
    group.addoption("--luxloop-out", metavar="DIR", default="runs", help="folder of the run folders [runs]")
    group.addoption("--luxloop-seeds", metavar="N", type=_count, default=1, help="seeds per scenario, from its own on")
    group.addoption("--luxloop-report", metavar="FILE", help="write an HTML report of all runs")
    group.addoption("--luxloop-record", action="store_true", help="write recordings, for luxloop view")


def _count(text: str) -> int:
    """Parse a whole number of at least 1. With 0 seeds, a suite would pass without a run."""
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} should be a whole number, 1 or more")
    return int(text)


def pytest_configure(config: pytest.Config) -> None:
    """Declare the markers, and register the report in the process that receives all results."""
    out = config.getoption("--luxloop-report")
    if out and not hasattr(config, "workerinput"):
        config.pluginmanager.register(SuiteReport(Path(out)))
    config.addinivalue_line("markers", 'smoke: scenarios with suite = "smoke", for every change')
    config.addinivalue_line("markers", "full: all scenarios")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> "ScenarioFile | None":
    """Collect every scenario, and every TOML file that is named on the command line."""
    if file_path.suffix != ".toml":
        return None
    named = parent.session.isinitpath(file_path)
    return (
        ScenarioFile.from_parent(parent, path=file_path) if named or _TRAFFIC.search(file_path.read_bytes()) else None
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Report a defect of luxloop as an error of the test: it is no failed expectation.

    pytest and its JUnit file take every exception outside the phase `call` for an error.
    """
    report = yield
    if isinstance(item, ScenarioItem) and call.when == "call" and call.excinfo:
        error = call.excinfo.value
        if isinstance(error, Exception) and not isinstance(error, RESULTS) and explain(error)[0] == ExitCode.INTERNAL:
            report.when = "setup"
            report.sections.append(("luxloop", request(error)))
    return report


class ScenarioFile(pytest.File):
    """A scenario file, with one seed or several."""

    def collect(self) -> Iterator["ScenarioItem"]:
        """Make a test for every seed. Errors of the file are reported when the test runs."""
        try:
            document = input_file.read_toml(self.path)
        except InputError:
            document = {}
        first, count = document.get("seed", DEFAULT_SEED), self.config.getoption("--luxloop-seeds")
        seeds = [first + n for n in range(count)] if type(first) is int else [None]
        for seed in seeds:
            name = self.path.stem if seed is None else f"{self.path.stem}-seed{seed}"
            yield ScenarioItem.from_parent(self, name=name, document=document, seed=seed)


class ScenarioItem(pytest.Item):
    """A run of a scenario."""

    def __init__(self, *, document: dict[str, Any], seed: int | None, **rest: Any) -> None:
        super().__init__(**rest)
        self.seed = seed  # None keeps the value of the file, which is not a valid seed
        self.add_marker("full")
        if document.get("suite") == "smoke":
            self.add_marker("smoke")
        known = _known_failures(document, self.config.getoption("--luxloop-tracker") or SHIPPED)
        if known:
            reason = "; ".join(f"{name}: {why}" for name, why in known.items())
            self.add_marker(pytest.mark.xfail(reason=reason, raises=KnownFailuresError, strict=False))

    def runtest(self) -> None:
        """Run the scenario, keep its folder, and record its figures for the JUnit file.

        SIGTERM and SIGHUP end the session as Ctrl-C does, with the exit codes of `luxloop`.
        """
        from luxloop.scenarios.run import termination

        with termination.as_interrupts() as received:
            try:
                self._run()
            except (KeyboardInterrupt, SystemError) as error:
                if not termination.is_interrupt(error):
                    raise
                termination.clear_unhandled()
                if received.exit_code != termination.CTRL_C:  # pytest has an exit code of its own for it
                    pytest.exit(f"interrupted in {self.name}", returncode=received.exit_code)
                raise KeyboardInterrupt from error

    def _run(self) -> None:
        from luxloop.scenarios.execute import execute
        from luxloop.scenarios.files.expect import exit_code
        from luxloop.scenarios.files.scenario import Scenario
        from luxloop.scenarios.run import device

        option = self.config.getoption
        scenario = Scenario.load(self.path, {} if self.seed is None else {"seed": self.seed})
        make_device = device.load(option("--luxloop-tracker") or device.SHIPPED)
        result = execute(scenario, make_device, self._out(), record=option("--luxloop-record"))
        self._add_properties(result)
        if exit_code(result.verdict):
            raise FailedRunError(self._explain(result))
        known = [check.name for check in result.checks if check.outcome == "known failure"]
        if known:
            raise KnownFailuresError(f"known to fail: {', '.join(known)}")

    def _out(self) -> Path:
        """Return the folder of the run. It repeats the file's path below pytest's root: file names may repeat."""
        above, root = self.path.parent, self.config.rootpath
        place = above.relative_to(root) if above.is_relative_to(root) else above.relative_to(above.anchor)
        return Path(self.config.getoption("--luxloop-out")) / place / self.name

    def _add_properties(self, result: "Result") -> None:
        """Record the figures for the JUnit file."""
        self.user_properties += [("seed", self.seed), ("trace_hash", result.trace_hash)]
        self.user_properties += [(FOLDER, str(result.out))]
        figures = {check.name: check.metric.value for check in result.checks}
        self.user_properties += [(name, "n/a" if value is None else value) for name, value in figures.items()]

    def _explain(self, result: "Result") -> str:
        """List the failed expectations with value, limit and worst frames, and the commands that show them.

        pytest's summary shows the first line.
        """
        from luxloop.scenarios.files.expect import unmet
        from luxloop.scenarios.grading.worst_frames import worst_frames
        from luxloop.scenarios.report.cells import exceeded, unit_of, value_of

        failed = [check for check in unmet(result.checks) if check.outcome == "failed"]
        early = [] if result.complete else [f"ended early, after {result.frames} frames: {result.ended_early}"]
        summary = "; ".join([*early, *(f"{check.name} {exceeded(check)}" for check in failed)])
        lines = [summary or NOTHING_OBSERVED, f"{result.scenario}: {result.config['description']}"]
        for check in failed:
            unit = unit_of(check.metric)
            lines.append(f"{check.name} = {value_of(check.metric)}{unit}, expected {check.limit}{unit}")
            lines += [f"    {check.why}"] if check.why else []
            lines += [f"    worst: {frame}" for frame in worst_frames(result, check.name)]
        lines += ["", "To run it again and view it:", *self._commands(result)]
        return "\n".join(lines)

    def _commands(self, result: "Result") -> list[str]:
        tracker = self.config.getoption("--luxloop-tracker")
        again = ["luxloop", "run", str(self.path), "--seed", str(self.seed), "--out", str(result.out)]
        commands = [again + (["--tracker", tracker] if tracker else []), ["luxloop", "view", str(result.out)]]
        return [f"    {shlex.join(command)}" for command in commands]

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Print failed expectations and bad input without a traceback. Other errors are defects and keep it."""
        error = excinfo.value
        code, message = explain(error)
        known = isinstance(error, RESULTS) or code != ExitCode.INTERNAL
        return message if known else super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Return the file and the name of the test."""
        return self.path, None, self.name


def _known_failures(document: dict[str, Any], tracker: str) -> dict[str, str]:
    """Return the reasons of a tracker's known failures by metric.

    A malformed file has none; its error is reported when it runs.
    """
    expect = document.get("expect")
    found = expect.items() if isinstance(expect, dict) else ()
    limits = {name: limit for name, limit in found if isinstance(limit, dict)}
    own = {name: limit for name, limit in limits.items() if limit.get("known_failure_of", SHIPPED) == tracker}
    return {name: why for name, limit in own.items() if (why := limit.get("known_failure"))}


class SuiteReport:
    """Plug-in of the process that receives the reports of all tests: of xdist's processes, the controller.

    Parameters
    ----------
    out
        The page to write.
    """

    def __init__(self, out: Path) -> None:
        self._out = out
        self._folders: list[Path] = []
        self._broken: list[tuple[str, str]] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Collect the folder of a run, or the error that prevented it."""
        if ".toml::" not in report.nodeid or not (report.when == "call" or report.failed):
            return
        folder = dict(report.user_properties).get(FOLDER)
        if folder is not None:
            self._folders.append(Path(str(folder)))
        elif report.failed:
            self._broken.append((report.nodeid, report.longreprtext))

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Write the page and print its path."""
        from luxloop.scenarios.document import html
        from luxloop.scenarios.report.html.suite_page import Broken, suite_page

        if self._folders or self._broken:
            html.write(self._out, suite_page(self._folders, [Broken(*one) for one in self._broken]))
            terminalreporter.write_line(f"The report is in {self._out}")
