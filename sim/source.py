"""What the run loop asks of traffic, whoever simulates it, and how traffic says that it cannot go on."""

from typing import Protocol

from sim.world import Obstacles, WorldFrame


class TrafficError(Exception):
    """Root of what a traffic source raises; the message is one line that names what, where and the remedy."""


class TrafficInputError(TrafficError):
    """What was asked for cannot be simulated: a missing file, an unknown id, a key out of range."""


class SimulatorFailedError(TrafficError):
    """The simulator behind the source gave up."""


class TrafficEndedError(TrafficError):
    """The run is over before its time: the ego arrived, was teleported or crashed."""


class TrafficSource(Protocol):
    """A stream of `WorldFrame`s at a fixed rate.

    Same seed, same frames, bit for bit. `reset` must come first; it may be called again for a new run.
    """

    dt: float
    """Time between frames [s]."""

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

    def close(self) -> None:
        """Release the simulator. Safe to call twice, and without `reset`."""
        ...
