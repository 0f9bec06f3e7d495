"""Draw the pictures of docs/traffic.md and print its figures, from SUMO's frames and the truth layer.

    python docs/draw_motion.py                # all, about fifteen seconds
    python docs/draw_motion.py lane_change    # selected ones

Each module of docs/motion_pictures that has a function `draw` makes one picture, docs/pictures/motion_<module>.png.
"""

import sys
from importlib import import_module

import matplotlib as mpl

PICTURES = ("lane_change", "turns", "shares")
FIGURES = "figures"


def main() -> None:
    """Draw and print the pictures named on the command line, or all."""
    mpl.use("Agg")
    for name in sys.argv[1:] or (*PICTURES, FIGURES):
        module = import_module(f"motion_pictures.{name}")
        (module.show if name == FIGURES else module.draw)()


if __name__ == "__main__":
    main()
