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


def collision_partner(collisions: Iterable[Any], name: str) -> str | None:
    """Return the other vehicle in the first collision of a vehicle, None without one.

    Parameters
    ----------
    collisions
        Collisions of a step, as libsumo reports them.
    """
    pairs = ((str(collision.collider), str(collision.victim)) for collision in collisions)
    return next((pair[pair[0] == name] for pair in pairs if name in pair), None)
