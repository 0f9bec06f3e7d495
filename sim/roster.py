"""Who is on the road: numbers, sizes and paint, the same for every traffic source."""

from collections.abc import Hashable
from dataclasses import dataclass

from sim.default_sizes import redrawn_size
from sim.reflectivity import paint_reflectivity
from sim.world import Kind

EGO_ID = 0
"""The ego is the first to be cast; actors count from 1."""


@dataclass(frozen=True, slots=True)
class Member:
    """What does not change about a road user."""

    id: int
    name: str
    kind: Kind
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    reflectivity: float


class Roster:
    """Everyone who has appeared in a run, numbered in order of appearance. Numbers are never reused.

    Parameters
    ----------
    seed
        Of the run.
    redraw_default_sizes
        Whether all but the ego, which is to fit its rig, get a size of their own in place of the simulator's default.
    """

    def __init__(self, seed: int, *, redraw_default_sizes: bool = False):
        self._seed = seed
        self._redraw = redraw_default_sizes
        self._members: dict[Hashable, Member] = {}

    def find(self, key: Hashable) -> Member | None:
        """Return the member whom the simulator calls `key`, or None before its first appearance."""
        return self._members.get(key)

    def enter(
        self,
        key: Hashable,
        kind: Kind,
        size: tuple[float, float, float],
        name: str = "",
        reflectivity: float | None = None,
    ) -> Member:
        """Cast a new member. Without a name it is `<kind>.<number>`; without reflectivity its paint is drawn."""
        number = len(self._members)
        if self._redraw and number != EGO_ID:
            size = redrawn_size(kind, size, self._seed, number)
        self._members[key] = Member(
            id=number,
            name=name or f"{kind.name.lower()}.{number}",
            kind=kind,
            size=size,
            reflectivity=paint_reflectivity(self._seed, number) if reflectivity is None else reflectivity,
        )
        return self._members[key]
