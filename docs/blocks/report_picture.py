"""Picture of the report of the crossing, by the system's Chromium."""

import io
import shutil
import tempfile
from pathlib import Path

from blocks import commands
from PIL import Image
from playwright.sync_api import sync_playwright

from luxloop.scenarios.document import html
from luxloop.scenarios.report.html.run_page import run_page

PICTURE = Path(__file__).parents[1] / "pictures" / "report.png"
SIZE = {"width": 1200, "height": 1280}
SHOWN = ("header", "#timelines")
"""Selectors of the parts that are scrolled to the top of a view."""
SCALE = 0.6
GAP = 16
"""Gap between the views [pixels]."""


def draw(_name: str) -> None:
    """Write the picture: the beginning of the report, and the timelines beside it."""
    page_text = html.page(run_page(commands.run("sumo-crossing")))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "report.html"
        path.write_text(page_text, encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        page.goto(path.as_uri())
        views = []
        for part in SHOWN:
            page.locator(part).evaluate("element => element.scrollIntoView()")
            views.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
        browser.close()
    save(views)


def save(views: list[Image.Image]) -> None:
    """Save the views side by side, scaled down for a page."""
    width, height = (round(SCALE * side) for side in (SIZE["width"], SIZE["height"]))
    whole = Image.new("RGB", (len(views) * (width + GAP) - GAP, height), "#d4d7d9")
    for k, view in enumerate(views):
        whole.paste(view.resize((width, height), Image.Resampling.LANCZOS), (k * (width + GAP), 0))
    steps = whole.point(lambda value: min(255, 8 * ((value + 4) // 8)))  # fewer colours give a smaller file
    steps.save(PICTURE, optimize=True)
