"""A real browser without network, for tests of pages."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from support.optional import need

OFFLINE = [
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-gpu",
    "--no-sandbox",  # root in a container has no sandbox
]

CUT = """all => all.filter(one => one.scrollWidth > one.clientWidth + 1).map(one => one.textContent.slice(0, 60))"""
"""Boxes that do not show their whole width."""


@contextmanager
def started() -> Iterator[Any]:
    """Start a browser; skip the test without one."""
    need("dev", "playwright")
    from playwright import sync_api

    found = [path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))]
    if not found:
        pytest.skip("no chromium, chromium-browser or google-chrome on PATH to open the page in")
    with sync_api.sync_playwright() as program:
        chromium = program.chromium.launch(executable_path=found[0], args=OFFLINE)
        yield chromium
        chromium.close()


@contextmanager
def opened(browser: Any, path: Path, **options: Any) -> Iterator[Any]:
    """Open a page; `recorded` collects its errors and requests, of which there should be none."""
    context = browser.new_context(**options)
    page = context.new_page()
    page.recorded = []
    page.on("console", lambda message: page.recorded.append(message.text))
    page.on("pageerror", lambda error: page.recorded.append(str(error)))
    page.on("request", lambda request: page.recorded.append(request.url))
    page.goto(path.as_uri())
    assert page.recorded.pop(0) == path.as_uri()
    yield page
    context.close()


def cut_off(page: Any) -> list[str]:
    """Return the beginnings of tables and figures that are wider than their boxes."""
    found: list[str] = page.locator(".scroll, .drawing").evaluate_all(CUT)
    return found
