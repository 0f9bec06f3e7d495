"""HTML report of a pytest session, over the runs of all its workers."""

from pathlib import Path

import pytest

FOLDER = "folder"
"""User property of a test with the folder of its run."""


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
