"""Recorded traffic, independent of the file format: road users, and samples of their poses."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from luxloop.arrays import Floats, Ints
from luxloop.sim.obstacles import Prism
from luxloop.sim.scripted.script import SIZE_BY_KIND, KindName, Size
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

KIND_BY_NAME = {kind.name.lower().replace("_", "-"): kind for kind in Kind}

_SUMO_DEFAULTS: dict[str, tuple[Kind, Size]] = {
    "DEFAULT_VEHTYPE": (Kind.CAR, (5.0, 1.8, 1.5)),
    "DEFAULT_TAXITYPE": (Kind.CAR, (5.0, 1.8, 1.5)),
    "DEFAULT_BIKETYPE": (Kind.BICYCLE, (1.6, 0.65, 1.7)),
    "DEFAULT_PEDTYPE": (Kind.PEDESTRIAN, (0.215, 0.478, 1.719)),
}
"""Kind and size [m] of SUMO's built-in vehicle types."""


@dataclass(frozen=True, slots=True)
class ReplayType:
    """Meaning of a file's name for a type of road user."""

    kind: KindName = "car"
    """Class of the road user."""
    size_m: Size | None = None
    """[m] Length, width, height if the file has no size; defaults to the size of the kind."""

    def __post_init__(self) -> None:
        if self.size_m is not None and min(self.size_m) <= 0:
            raise ValueError("size_m needs a positive length, width and height")


@dataclass(frozen=True, slots=True)
class RoadUser:
    """A recorded road user."""

    name: str
    """Id in the file."""
    kind: Kind
    size: Size
    """Length, width, height [m]."""
    reflectivity: float | None = None
    """Diffuse reflectivity of the paint, 0 to 1; drawn at random if None."""


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Content of a file: S samples in any order, of U road users."""

    users: list[RoadUser]
    user: Ints
    """(S,) row in `users`."""
    time: Floats
    """(S,) [s] by the file's clock."""
    pose: Floats
    """(S, 3) box centre x [m], y [m], yaw [rad] in the file's coordinates; NaN if the file has no yaw."""
    street: list[Prism] = field(default_factory=list)
    """Static obstacles, in the file's coordinates."""


def kind_and_size(word: str, types: Mapping[str, ReplayType]) -> tuple[Kind, Size]:
    """Return kind and size for a file's type name: by `types`, else by the names of kinds and of SUMO's built-in types.

    Raises
    ------
    TrafficInputError
        The name is unknown.
    """
    if word in types:
        kind = KIND_BY_NAME[types[word].kind]
        return kind, types[word].size_m or SIZE_BY_KIND[kind]
    if word in KIND_BY_NAME:
        return KIND_BY_NAME[word], SIZE_BY_KIND[KIND_BY_NAME[word]]
    if word in _SUMO_DEFAULTS:
        return _SUMO_DEFAULTS[word]
    raise TrafficInputError(
        f'type "{word}" is neither in traffic.types nor a kind ({", ".join(KIND_BY_NAME)}); '
        f'add types."{word}" = {{ kind = "car", size_m = [4.7, 1.8, 1.5] }} with its kind and size'
    )
