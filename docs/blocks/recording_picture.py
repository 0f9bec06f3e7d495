"""Picture of the recording of the crossing, by the rerun viewer in headless mode.

Requires the rerun program on PATH (`. .venv/bin/activate`) and a graphics driver. Mesa's software driver lavapipe is
sufficient (Debian: mesa-vulkan-drivers).
"""

import io
import time
from pathlib import Path

from blocks import commands
from PIL import Image
from rerun.experimental import ViewerClient

PICTURE = Path(__file__).parents[1] / "pictures" / "recording.png"
WIDTH = 1600
AT_S = 20.0
"""Simulated time of the picture."""
TOP_BAR = 36
"""Height of the viewer's menu, which is cropped [pixels of 1920 x 1080]."""
LOADING_S = 120.0
"""Longest wait for a recording [s]."""
SETTLE_S = 4.0
"""Waiting time for drawing [s]. The viewer does not report when it is done."""


def screenshot(recording: Path, at_s: float) -> Image.Image:
    """Open a recording at a simulated time and return a screenshot of the viewer."""
    viewer = ViewerClient.spawn(headless=True, port=9898, hide_welcome_screen=True)
    try:
        viewer.open(str(recording.resolve()))
        wait_until_loaded(viewer)
        viewer.set_time("sim_time", duration=at_s, play_state="paused")
        time.sleep(SETTLE_S)
        return Image.open(io.BytesIO(viewer.take_screenshot()))
    finally:
        viewer.quit()


def wait_until_loaded(viewer: ViewerClient) -> None:
    """Wait until the viewer has loaded its recording; a TimeoutError is raised after `LOADING_S`."""
    deadline = time.monotonic() + LOADING_S
    while not (state := viewer.get_state()).recordings or state.loading:
        if time.monotonic() > deadline:
            raise TimeoutError(f"the viewer has not loaded its recording after {LOADING_S:g} s")
        time.sleep(0.2)


def draw(_name: str) -> None:
    """Write the picture, with colours in steps of 8 for a small file."""
    image = screenshot(commands.run("sumo-crossing", recording=True) / "recording.rrd", AT_S).convert("RGB")
    image = image.crop((0, TOP_BAR, image.width, image.height))
    image = image.resize((WIDTH, round(image.height * WIDTH / image.width)), Image.Resampling.BILINEAR)
    image.point(lambda value: min(255, 8 * ((value + 4) // 8))).save(PICTURE, optimize=True)
