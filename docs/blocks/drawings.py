"""Pictures that modules of docs/sensor_pictures and docs/motion_pictures draw from luxloop's code."""

from importlib import import_module

import matplotlib as mpl


def draw(name: str) -> None:
    """Draw `sensor_MODULE` or `motion_MODULE`."""
    mpl.use("Agg")
    package, _, module = name.partition("_")
    import_module(f"{package}_pictures.{module}").draw()


def motion(name: str) -> str:
    """Return the table `severity` or `deviation` of the motion of bodies."""
    tables: dict[str, str] = import_module("motion_pictures.figures").tables()
    return tables[name]
