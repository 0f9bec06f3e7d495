"""Causes of incidents in SUMO traffic: collisions, and nets without lanes across their junctions."""

from collections.abc import Iterable
from typing import Any

NO_INTERNAL_LINKS = "the net has no lanes across its junctions (netconvert --no-internal-links)"

WARNING = (
    f"{NO_INTERNAL_LINKS}: vehicles jump across them, with accelerations that no vehicle has "
    "(sim.teleports, sim.limit_violations); build the net again without this option"
)
"""Warning about a net without internal lanes."""


def has_internal_lanes(sumo: Any) -> bool:
    """Return True if lanes lead across the junctions of the net, or no junction is crossed.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    """
    lanes = sumo.lane.getIDList()
    return any(lane.startswith(":") for lane in lanes) or not any(sumo.lane.getLinkNumber(lane) for lane in lanes)


def keeps_collided(sumo: Any) -> bool:
    """Return True if vehicles that collide drive on (`collision.action` is `warn`): frames then show their overlap.

    SUMO also reports gaps below `minGap` as collisions, so that its report is not needed there, and often wrong.
    """
    return str(sumo.simulation.getOption("collision.action")) == "warn"


def collision_partners(collisions: Iterable[Any], name: str) -> list[tuple[str, float]]:
    """Return the other road user in each collision of a vehicle, and the speed of the collider [m/s].

    Parameters
    ----------
    collisions
        Collisions of a step, as libsumo reports them.
    """
    pairs = (((str(one.collider), str(one.victim)), float(one.colliderSpeed)) for one in collisions)
    return [(pair[pair[0] == name], speed) for pair, speed in pairs if name in pair]
