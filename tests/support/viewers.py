"""Viewers of recordings in browsers."""

import re
import subprocess

import pytest

PAGE = re.compile(r"web-viewer at (http://127\.0\.0\.1:\d+)")


def page_of(viewer: "subprocess.Popen[str]") -> str:
    """Return the address of a viewer's page, from its messages; fail with these if the viewer ends before."""
    printed = []
    for line in viewer.stderr or ():
        printed.append(line)
        if hosted := PAGE.search(line):
            return hosted[1]
    pytest.fail(f"exit code {viewer.wait()} without a page:\n{''.join(printed)}")
