"""Proportions of two-wheelers with their riders, and of pedestrians."""

from dataclasses import dataclass

from luxloop.sensor_model.bodies.proportions import Draw


@dataclass(frozen=True, slots=True)
class RiderProportions:
    """Two-wheelers and their riders. Lengths [m], heights [m] above the ground."""

    wheel_radius: float
    wheel_width: float
    seat: float
    bar: float
    """Height of the handlebar."""
    hips: float
    """Half the width of the rider's hips and legs."""
    shoulders: float
    """Half the width of the rider's shoulders."""
    bend: float
    """Offset of the shoulders in front of the hips."""


def motorcycle(draw: Draw) -> RiderProportions:
    """Draw a motorcycle with its rider."""
    return RiderProportions(
        wheel_radius=draw(0.29, 0.33),
        wheel_width=draw(0.12, 0.18),
        seat=draw(0.75, 0.85),
        bar=draw(0.96, 1.04),
        hips=draw(0.24, 0.30),
        shoulders=draw(0.22, 0.26),
        bend=draw(0.15, 0.30),
    )


def bicycle(draw: Draw) -> RiderProportions:
    """Draw a bicycle with its rider."""
    return RiderProportions(
        wheel_radius=draw(0.32, 0.35),
        wheel_width=draw(0.03, 0.05),
        seat=draw(0.85, 0.95),
        bar=draw(0.95, 1.08),
        hips=draw(0.15, 0.19),
        shoulders=draw(0.20, 0.23),
        bend=draw(0.15, 0.35),
    )


@dataclass(frozen=True, slots=True)
class FigureProportions:
    """Pedestrians; heights as shares of the body height."""

    waist: float
    shoulders: float
    hips: float
    """Width of hips and legs as a share of the width of the shoulders."""
    head: float
    """Width of the head as a share of the width of the shoulders."""


def pedestrian(draw: Draw) -> FigureProportions:
    """Draw a pedestrian."""
    return FigureProportions(
        waist=draw(0.52, 0.58), shoulders=draw(0.80, 0.83), hips=draw(0.70, 0.82), head=draw(0.38, 0.44)
    )
