"""Pictures of the crossing's report in the system's Chromium, and of its recording in the rerun viewer.

The viewer requires the rerun program on PATH (`. .venv/bin/activate`) and a graphics driver. Mesa's software driver
lavapipe is sufficient (Debian: mesa-vulkan-drivers).
"""

import io
import shutil
import tempfile
import time
from pathlib import Path

from blocks import commands
from PIL import Image
from playwright.sync_api import ViewportSize, sync_playwright
from rerun.experimental import ViewerClient

from luxloop.scenarios.document import html
from luxloop.scenarios.report.html.run_page import run_page

PICTURES = Path(__file__).parents[1] / "pictures"
SIZE = ViewportSize(width=1200, height=1280)
SHOWN = ("header", "#timelines")
"""Selectors of the parts of the report that are scrolled to the top of a view."""
SCALE = 0.6
GAP = 16
"""Gap between the views [pixels]."""
WIDTH = 1600
AT_S = 20.0
"""Simulated time of the recording."""
TOP_BAR = 36
"""Height of the viewer's menu, which is cropped [pixels of 1920 x 1080]."""
LOADING_S = 120.0
"""Longest wait for a recording [s]."""
SETTLE_S = 4.0
"""Waiting time for drawing [s]. The viewer does not report when it is done."""


def report(_name: str) -> None:
    """Write the picture of the report: its beginning, and the timelines beside it."""
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
    width, height = (round(SCALE * side) for side in (SIZE["width"], SIZE["height"]))
    whole = Image.new("RGB", (len(views) * (width + GAP) - GAP, height), "#d4d7d9")
    for k, view in enumerate(views):
        whole.paste(view.resize((width, height), Image.Resampling.LANCZOS), (k * (width + GAP), 0))
    save(whole, "report")


def recording(_name: str) -> None:
    """Write the picture of the recording."""
    image = viewed(commands.run("sumo-crossing", recording=True) / "recording.rrd")
    image = image.crop((0, TOP_BAR, image.width, image.height))
    save(image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.BILINEAR), "recording")


def viewed(path: Path) -> Image.Image:
    """Return a screenshot of the viewer; a TimeoutError is raised if it does not load the recording."""
    viewer = ViewerClient.spawn(headless=True, port=9898, hide_welcome_screen=True)
    try:
        viewer.open(str(path.resolve()))
        deadline = time.monotonic() + LOADING_S
        while not (state := viewer.get_state()).recordings or state.loading:
            if time.monotonic() > deadline:
                raise TimeoutError(f"the viewer has not loaded its recording after {LOADING_S:g} s")
            time.sleep(0.2)
        viewer.set_time("sim_time", duration=AT_S, play_state="paused")
        time.sleep(SETTLE_S)
        return Image.open(io.BytesIO(viewer.take_screenshot())).convert("RGB")
    finally:
        viewer.quit()


def save(image: Image.Image, name: str) -> None:
    """Save a picture with colours in steps of 8, for a small file."""
    image.point(lambda value: min(255, 8 * ((value + 4) // 8))).save(PICTURES / f"{name}.png", optimize=True)
