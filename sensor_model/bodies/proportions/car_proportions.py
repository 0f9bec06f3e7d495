"""Proportions of small cars, sedans, estates, sport utility vehicles, pickups and vans.

Bows of ends follow measurements on 55 real vehicles from roofs, 54 more from roofs and 89 at bumper height: over 0.75 m
to either side, medians of 0.10, 0.26 and 0.21 m below 0.45 m of height, 0.165, 0.17 and 0.17 m up to 0.75 m, 0.24, 0.18
and 0.17 m up to 1.0 m, and 0.13, 0.18 and 0.10 m on glass and hood. Layers across an end lie 0.12 m apart at bumper
height, those across a flank 0.04 m (medians). Ranges are smaller than the measured spread where corners and wheels add
to it.
"""

from dataclasses import dataclass, replace

from luxloop.sensor_model.bodies.proportions import Draw
from luxloop.sensor_model.bodies.proportions.fitting_proportions import Bow, Glazing, MirrorBox


@dataclass(frozen=True, slots=True)
class CarProportions:
    """Passenger cars and vans. Lengths [m], heights [m] above the ground."""

    clearance: float
    wheel_radius: float
    wheel_inset: float
    """Inset of the tyres' outer faces from the fenders."""
    front_overhang: float
    """Front bumper to front axle."""
    rear_overhang: float
    """Rear axle to rear bumper."""
    bumper_bottom: float
    bumper_top: float
    nose: float
    """Setback of the hood's front edge from the bumper."""
    hood_front: float
    hood_rear: float
    """Height of the hood's rear edge, at the foot of the windscreen."""
    hood_share: float
    """Front bumper to the foot of the windscreen, as a share of the length."""
    deck: float
    """Foot of the rear window to rear bumper; a van has none."""
    deck_height: float
    tail: float
    """Setback of the deck's rear edge from the bumper."""
    corner: float
    """Width of the bevels between ends and sides."""
    front_bow: Bow
    rear_bow: Bow
    side_bow: float
    """Sagitta of the sides over 1.6 m to either side of the middle."""
    glazing: Glazing
    mirror: MirrorBox


SIDE_BOW = (0.01, 0.04)
"""[m] Range of the flanks' sagitta over 1.6 m. Between 0.45 and 1.0 m of height, scan lines over real flanks have 0.022
to 0.039 m (medians of 9 to 61 vehicles by band, from a roof and at bumper height); corners add 0.01 m to a body's."""


def _front_bow(draw: Draw) -> Bow:
    return Bow(draw(0.08, 0.20), draw(0.03, 0.12), draw(0.14, 0.29), draw(0.10, 0.22))


def _rear_bow(draw: Draw) -> Bow:
    return Bow(draw(0.08, 0.19), draw(0.03, 0.11), draw(0.14, 0.27), draw(0.10, 0.20))


def small_car(draw: Draw) -> CarProportions:
    """Draw a small hatchback, 3.5 to 4.2 m long."""
    return CarProportions(
        clearance=draw(0.13, 0.17),
        wheel_radius=draw(0.28, 0.31),
        wheel_inset=draw(0.0, 0.03),
        front_overhang=draw(0.72, 0.82),
        rear_overhang=draw(0.55, 0.68),
        bumper_bottom=draw(0.30, 0.36),
        bumper_top=draw(0.58, 0.64),
        nose=draw(0.10, 0.16),
        hood_front=draw(0.70, 0.76),
        hood_rear=draw(0.96, 1.00),
        hood_share=draw(0.22, 0.25),
        deck=draw(0.12, 0.20),
        deck_height=draw(1.01, 1.03),
        tail=draw(0.08, 0.14),
        corner=draw(0.10, 0.20),
        front_bow=_front_bow(draw),
        rear_bow=_rear_bow(draw),
        side_bow=draw(*SIDE_BOW),
        glazing=Glazing(
            windscreen_deg=draw(29.0, 35.0),
            backlight_deg=draw(52.0, 68.0),
            tumblehome_deg=draw(14.0, 18.0),
            shoulder=draw(0.07, 0.10),
            front_pillar=draw(0.09, 0.12),
            rear_pillar=draw(0.20, 0.30),
            frame=draw(0.08, 0.12),
        ),
        mirror=MirrorBox(draw(0.12, 0.17), draw(0.13, 0.18), draw(0.14, 0.17), draw(1.00, 1.06), draw(0.14, 0.16)),
    )


def sedan(draw: Draw) -> CarProportions:
    """Draw a sedan, 4.4 to 5.0 m long."""
    return CarProportions(
        clearance=draw(0.13, 0.17),
        wheel_radius=draw(0.31, 0.33),
        wheel_inset=draw(0.0, 0.03),
        front_overhang=draw(0.85, 0.95),
        rear_overhang=draw(0.95, 1.05),
        bumper_bottom=draw(0.32, 0.38),
        bumper_top=draw(0.60, 0.64),
        nose=draw(0.08, 0.12),
        hood_front=draw(0.67, 0.73),
        hood_rear=draw(0.93, 0.96),
        hood_share=draw(0.27, 0.29),
        deck=draw(0.55, 0.70),
        deck_height=draw(0.98, 1.02),
        tail=draw(0.10, 0.16),
        corner=draw(0.10, 0.20),
        front_bow=_front_bow(draw),
        rear_bow=_rear_bow(draw),
        side_bow=draw(*SIDE_BOW),
        glazing=Glazing(
            windscreen_deg=draw(28.0, 32.0),
            backlight_deg=draw(28.0, 35.0),
            tumblehome_deg=draw(16.0, 19.0),
            shoulder=draw(0.07, 0.10),
            front_pillar=draw(0.09, 0.12),
            rear_pillar=draw(0.20, 0.30),
            frame=draw(0.08, 0.12),
        ),
        mirror=MirrorBox(draw(0.12, 0.17), draw(0.13, 0.18), draw(0.14, 0.17), draw(0.98, 1.02), draw(0.15, 0.17)),
    )


def estate(draw: Draw) -> CarProportions:
    """Draw an estate, 4.4 to 5.0 m long: a sedan with a steep rear window at its end."""
    like = sedan(draw)
    return replace(
        like,
        deck=draw(0.13, 0.20),
        deck_height=draw(1.00, 1.02),
        tail=draw(0.08, 0.14),
        glazing=replace(like.glazing, backlight_deg=draw(48.0, 65.0)),
    )


def suv(draw: Draw) -> CarProportions:
    """Draw a sport utility vehicle or a tall hatchback, 4.3 to 4.9 m long."""
    return CarProportions(
        clearance=draw(0.18, 0.22),
        wheel_radius=draw(0.34, 0.38),
        wheel_inset=draw(0.0, 0.03),
        front_overhang=draw(0.85, 0.95),
        rear_overhang=draw(0.90, 1.00),
        bumper_bottom=draw(0.36, 0.44),
        bumper_top=draw(0.72, 0.78),
        nose=draw(0.12, 0.18),
        hood_front=draw(0.89, 0.95),
        hood_rear=draw(1.06, 1.09),
        hood_share=draw(0.26, 0.28),
        deck=draw(0.06, 0.12),
        deck_height=draw(1.09, 1.11),
        tail=draw(0.08, 0.14),
        corner=draw(0.10, 0.20),
        front_bow=_front_bow(draw),
        rear_bow=_rear_bow(draw),
        side_bow=draw(*SIDE_BOW),
        glazing=Glazing(
            windscreen_deg=draw(30.0, 38.0),
            backlight_deg=draw(57.0, 73.0),
            tumblehome_deg=draw(12.0, 15.0),
            shoulder=draw(0.05, 0.08),
            front_pillar=draw(0.10, 0.13),
            rear_pillar=draw(0.15, 0.25),
            frame=draw(0.08, 0.12),
        ),
        mirror=MirrorBox(draw(0.12, 0.17), draw(0.14, 0.20), draw(0.15, 0.19), draw(1.13, 1.17), draw(0.17, 0.19)),
    )


def pickup(draw: Draw) -> CarProportions:
    """Draw a pickup with a double cab, 5.2 to 6.0 m long: its deck is the load bed, at the height of the bed's walls.

    Sizes are those of four labelled pickups (docs/realism.md); hoods of pickups are 1.02 m and higher (IIHS). The
    bed is an estimate: 1.5 to 1.8 m long, flat at the rear, as its flanks nearly are.
    """
    return CarProportions(
        clearance=draw(0.21, 0.26),
        wheel_radius=draw(0.37, 0.40),
        wheel_inset=draw(0.0, 0.03),
        front_overhang=draw(0.88, 0.98),
        rear_overhang=draw(1.15, 1.30),
        bumper_bottom=draw(0.44, 0.50),
        bumper_top=draw(0.78, 0.84),
        nose=draw(0.06, 0.10),
        hood_front=draw(1.02, 1.08),
        hood_rear=draw(1.15, 1.19),
        hood_share=draw(0.25, 0.27),
        deck=draw(1.50, 1.80),
        deck_height=draw(1.20, 1.26),
        tail=draw(0.05, 0.10),
        corner=draw(0.08, 0.14),
        front_bow=_front_bow(draw),
        rear_bow=Bow(draw(0.02, 0.06), draw(0.03, 0.08), draw(0.02, 0.05), draw(0.02, 0.05)),
        side_bow=draw(0.0, 0.02),
        glazing=Glazing(
            windscreen_deg=draw(32.0, 38.0),
            backlight_deg=draw(72.0, 82.0),
            tumblehome_deg=draw(10.0, 14.0),
            shoulder=draw(0.05, 0.08),
            front_pillar=draw(0.10, 0.13),
            rear_pillar=draw(0.12, 0.20),
            frame=draw(0.08, 0.12),
        ),
        mirror=MirrorBox(draw(0.12, 0.17), draw(0.16, 0.21), draw(0.18, 0.24), draw(1.24, 1.30), draw(0.16, 0.18)),
    )


def van(draw: Draw) -> CarProportions:
    """Draw a van, 4.7 to 6.5 m long; its rear pillars are behind the doors of the cab."""
    return CarProportions(
        clearance=draw(0.16, 0.20),
        wheel_radius=draw(0.32, 0.36),
        wheel_inset=draw(0.0, 0.03),
        front_overhang=draw(0.90, 1.05),
        rear_overhang=draw(0.95, 1.15),
        bumper_bottom=draw(0.33, 0.38),
        bumper_top=draw(0.72, 0.78),
        nose=draw(0.08, 0.12),
        hood_front=draw(0.93, 0.98),
        hood_rear=draw(1.13, 1.17),
        hood_share=draw(0.14, 0.17),
        deck=0.0,
        deck_height=draw(1.18, 1.19),
        tail=draw(0.01, 0.03),
        corner=draw(0.12, 0.22),
        front_bow=_front_bow(draw),
        rear_bow=Bow(draw(0.02, 0.06), draw(0.03, 0.08), draw(0.02, 0.05), draw(0.02, 0.05)),
        side_bow=draw(0.01, 0.03),
        glazing=Glazing(
            windscreen_deg=draw(41.0, 49.0),
            backlight_deg=draw(84.0, 89.0),
            tumblehome_deg=draw(3.5, 7.5),
            shoulder=draw(0.04, 0.06),
            front_pillar=draw(0.10, 0.14),
            rear_pillar=draw(0.08, 0.12),
            frame=draw(0.08, 0.12),
        ),
        mirror=MirrorBox(draw(0.13, 0.17), draw(0.16, 0.21), draw(0.22, 0.28), draw(1.28, 1.38), draw(0.28, 0.31)),
    )
