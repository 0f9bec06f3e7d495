"""Draw the animation of the README: the scenario `sumo-crossing` from above, with LIDAR points, fits and tracks."""

from pathlib import Path

import matplotlib as mpl
from crossing_picture.frame import picture
from crossing_picture.scene import play
from PIL import Image

PICTURE = Path(__file__).parents[1] / "pictures" / "crossing.gif"
EVERY = 2
"""Frames from one picture to the next."""
PICTURE_MS = 160
"""Time that a picture is shown: real time [ms]."""
COLORS = 128


def draw(_name: str) -> None:
    """Write the animation; half a minute."""
    mpl.use("Agg")
    obstacles, steps = play()
    save([picture(step, obstacles) for n, step in enumerate(steps) if n % EVERY == 0])


def save(pictures: list[Image.Image]) -> None:
    """Write pictures as an animation, with one palette for all so that still parts cost nothing."""
    sample = Image.new("RGB", (pictures[0].width, 3 * pictures[0].height))
    for n, shown in enumerate((0, len(pictures) // 2, -1)):
        sample.paste(pictures[shown], (0, n * pictures[0].height))
    palette = sample.quantize(COLORS, method=Image.Quantize.MAXCOVERAGE, kmeans=3)
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in pictures]
    frames[0].save(PICTURE, save_all=True, append_images=frames[1:], duration=PICTURE_MS, loop=0, optimize=True)
