"""Draw the pictures of docs/sensor.md from the sensor's code.

    python docs/draw_sensor.py                # all, about fifteen seconds
    python docs/draw_sensor.py beams echoes   # some of them

Each module of docs/sensor_pictures that has a function `draw` makes one picture, docs/pictures/sensor_<module>.png.
"""

import sys
from importlib import import_module

import matplotlib as mpl

PICTURES = (
    "beams", "footprint", "echoes", "power", "sweep", "attitude", "suspension", "causes", "ranging", "losses",
    "weather", "visibility", "slope",
)  # fmt: skip


def main() -> None:
    """Draw the named pictures, or all."""
    mpl.use("Agg")
    for name in sys.argv[1:] or PICTURES:
        import_module(f"sensor_pictures.{name}").draw()


if __name__ == "__main__":
    main()
