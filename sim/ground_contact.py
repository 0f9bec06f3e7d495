"""Height and slope of bodies on the ground."""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats
from luxloop.sim.world import Terrain

WHEELBASE_SHARE = 0.6
"""Share of a body's length between its points of contact: the wheelbase of cars is 0.55 to 0.65 of their length."""
TRACK_SHARE = 0.85
"""Share of a body's width between its wheels: 1.55 m of 1.8 m for a car."""
DECK_M = 0.3
"""[m] A simulator's road this far above a wheel's ground is a bridge: more than half a wheelbase at 15 % explains."""


def ground_contact(terrain: Terrain, pose_world: Floats, size: Floats, road: Floats | None) -> tuple[Floats, Floats]:
    """Return height and slope of the planes on which N bodies stand.

    Each stands on four points. The height under its centre is their mean; pitch and roll are the slopes between their
    pairs, so that a body passes a kink of the road gradually. A body on a bridge, which the terrain does not contain,
    takes the height and slope of the simulator's road.

    Parameters
    ----------
    terrain
        Height of the ground.
    pose_world, size
        (N, 3) x [m], y [m], yaw [rad]; (N, 3) length, width, height [m].
    road
        (N, 2) as in `kinematics.RawFrame`.

    Returns
    -------
    (N,) height [m]; (N, 2) pitch, positive with the front down, and roll, positive with the right side down [rad].
    """
    cos, sin = elementwise.cos(pose_world[:, 2]), elementwise.sin(pose_world[:, 2])
    ahead = 0.5 * WHEELBASE_SHARE * size[:, :1] * np.column_stack([cos, sin])
    aside = 0.5 * TRACK_SHARE * size[:, 1:2] * np.column_stack([-sin, cos])
    middle = pose_world[:, :2]
    front_left, front_right, rear_left, rear_right = (
        terrain.height_at(middle + along * ahead + across * aside) for along in (1, -1) for across in (1, -1)
    )
    rise = 0.5 * (front_left + front_right - rear_left - rear_right)
    bank = 0.5 * (front_left + rear_left - front_right - rear_right)
    height = 0.25 * (front_left + front_right + rear_left + rear_right)
    pitch, roll = (
        -elementwise.atan2(rise, 2.0 * elementwise.hypot(*ahead.T)),
        elementwise.atan2(bank, 2.0 * elementwise.hypot(*aside.T)),
    )
    if road is not None:
        lowest = np.minimum.reduce([front_left, front_right, rear_left, rear_right])
        on_deck = road[:, 0] > lowest + DECK_M  # False for NaN
        height = np.where(on_deck, road[:, 0], height)
        pitch, roll = np.where(on_deck, -road[:, 1], pitch), np.where(on_deck, 0.0, roll)
    return height, np.column_stack([pitch, roll])
