"""What the run loop asks of traffic, whoever simulates it, and how traffic says that it cannot go on."""

from dataclasses import dataclass
from typing import Any, Protocol

from sim.arrays import Floats
from sim.world import Obstacles, WorldFrame


class TrafficError(Exception):
    """Root of what a traffic source raises; the message is one line that names what, where and the remedy."""


class TrafficInputError(TrafficError):
    """What was asked for cannot be simulated: a missing file, an unknown id, a key out of range."""


class SimulatorFailedError(TrafficError):
    """The simulator behind the source gave up."""


class TrafficEndedError(TrafficError):
    """The run is over before its time: the ego arrived, was teleported or crashed."""


@dataclass(frozen=True, slots=True)
class EgoCommand:
    """What a controller wants of the ego. Each source takes the fields it understands, and refuses others."""

    speed_mps: float | None = None
    """[m/s] to reach as soon as the vehicle can, and to keep (SUMO)."""
    lane: int | None = None
    """Lane to change to, counted from the right, 0 first (SUMO)."""
    action: Any = None
    """An action of the environment: an index, or an array of them or of floats (highway-env)."""


class TrafficSource(Protocol):
    """A stream of `WorldFrame`s at a fixed rate.

    Same seed, same commands, same frames, bit for bit. `reset` must come first; it may be called again for a new run.
    """

    dt: float
    """Time between frames [s]."""
    origin: Floats
    """(2,) [m] where the world frame's origin lies in the simulator's own coordinates; valid after `reset`. Zero for
    the usual small map; else full 10 km, so that float32 still tells millimetres near the ego."""

    def reset(self, seed: int) -> Obstacles:
        """Start a new run and return its static obstacles.

        Raises
        ------
        TrafficInputError
            What was asked for does not exist or is out of range.
        SimulatorFailedError
            The simulator did not start.
        """
        ...

    def step(self) -> WorldFrame:
        """Return the next frame; the first call after `reset` returns frame 0.

        Raises
        ------
        TrafficEndedError
            There is no next frame: the ego is gone.
        SimulatorFailedError
            The simulator gave up in mid-run.
        """
        ...

    def apply(self, command: EgoCommand) -> None:
        """Command the ego, from the next `step` on and until the next command.

        Raises
        ------
        TrafficInputError
            The command is not for this kind of traffic, or the source was not set up for a controlled ego.
        """
        ...

    def close(self) -> None:
        """Release the simulator. Safe to call twice, and without `reset`."""
        ...
