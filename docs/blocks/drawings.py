"""Pictures that modules of docs/sensor_pictures draw from the sensor's code."""

from importlib import import_module

import matplotlib as mpl


def draw(name: str) -> None:
    """Draw `sensor_MODULE`."""
    mpl.use("Agg")
    import_module(f"sensor_pictures.{name.removeprefix('sensor_')}").draw()
