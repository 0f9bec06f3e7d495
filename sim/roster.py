"""Road users of a run: ids, sizes and paint, assigned in the same way for every traffic source."""

from collections.abc import Hashable
from dataclasses import dataclass

from luxloop.sim.actor_draws import paint_reflectivity, redrawn_size
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

LARGEST_M = 1000.0
"""Longest side of a body [m]; trains have several hundred metres."""
EGO_ID = 0
"""The ego is added first; actors count from 1."""


@dataclass(frozen=True, slots=True)
class Member:
    """Constant properties of a road user."""

    id: int
    name: str
    kind: Kind
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    reflectivity: float
    stretch: int = 0
    """Number of the uninterrupted motion: it increases when the simulator moves the same road user to another place."""


class Roster:
    """All road users that have appeared in a run, numbered in order of appearance. Numbers are never reused.

    Size and paint are drawn by name, so that they do not depend on the order of appearance.

    Parameters
    ----------
    seed
        Seed of the run.
    redraw_default_sizes
        Replace the simulator's default sizes by random ones. The ego keeps its size, which the rig is fitted to.
    """

    def __init__(self, seed: int, *, redraw_default_sizes: bool = False):
        self._seed = seed
        self._redraw = redraw_default_sizes
        self._members: dict[Hashable, Member] = {}

    def find(self, key: Hashable) -> Member | None:
        """Return the member with the simulator's key, or None before its first appearance."""
        return self._members.get(key)

    def add(
        self,
        key: Hashable,
        kind: Kind,
        size: tuple[float, float, float],
        name: str = "",
        reflectivity: float | None = None,
    ) -> Member:
        """Add a member. The default name is `<kind>.<number>`; the default reflectivity is drawn at random.

        Raises
        ------
        TrafficInputError
            Its size [m] is one that no body has.
        """
        number = len(self._members)
        name = name or f"{kind.name.lower()}.{number}"
        if not all(0.0 < side <= LARGEST_M for side in size):
            sides = " x ".join(f"{side:g}" for side in size)
            raise TrafficInputError(
                f"{name} is {sides} m large; each side should be above 0 and at most {LARGEST_M:g} m"
            )
        if self._redraw and number != EGO_ID:
            size = redrawn_size(kind, size, self._seed, name)
        self._members[key] = Member(
            id=number,
            name=name,
            kind=kind,
            size=size,
            reflectivity=paint_reflectivity(self._seed, name, kind) if reflectivity is None else reflectivity,
        )
        return self._members[key]
