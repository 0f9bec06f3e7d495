"""Pictures of the crossing's report in the system's Chromium, and of its recording in the rerun viewer.

The viewer requires the rerun program on PATH (`. .venv/bin/activate`) and a graphics driver. Mesa's software driver
lavapipe is sufficient (Debian: mesa-vulkan-drivers).
"""

import io
import shutil
import time
from pathlib import Path

import numpy as np
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
SMALL = (720, 768)
"""Size of a view in the picture [pixels]."""
GAP, GREY = 16, 216
"""Width and colour of the gap between the views."""
WIDTH, AT_S = 1600, 20.0
"""Width of the picture of the recording [pixels], and its simulated time."""
TOP_BAR = 36
"""Height of the viewer's menu, which is cropped [pixels of 1920 x 1080]."""
LOADING_S = 120.0
"""Longest wait for a recording [s]."""
SETTLE_S = 4.0
"""Waiting time for drawing [s]. The viewer does not report when it is done."""


def report(_name: str) -> None:
    """Write the picture of the report: its beginning, and the timelines beside it."""
    views = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)
        page.set_content(html.page(run_page(commands.run("sumo-crossing"))))
        for part in SHOWN:
            page.locator(part).evaluate("element => element.scrollIntoView()")
            view = Image.open(io.BytesIO(page.screenshot())).convert("RGB").resize(SMALL, Image.Resampling.LANCZOS)
            views.append(np.pad(view, ((0, 0), (0, GAP), (0, 0)), constant_values=GREY))
        browser.close()
    save(Image.fromarray(np.hstack(views)[:, :-GAP]), "report")


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
