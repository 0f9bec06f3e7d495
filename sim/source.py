"""Interface between the run loop and a traffic source, with its errors."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from luxloop.arrays import Floats
from luxloop.errors import Error
from luxloop.sim.world import Collision, Obstacles, WorldFrame


class TrafficError(Error):
    """Base class of traffic errors; the message is one line that names the cause, its location and the remedy."""


class TrafficInputError(TrafficError):
    """The input cannot be simulated: a missing file, an unknown id, a key out of range."""


class SimulatorFailedError(TrafficError):
    """The simulator behind the source failed."""


class TrafficEndedError(TrafficError):
    """The run ended early: the ego arrived, was teleported or crashed.

    Parameters
    ----------
    message
        The reason.
    collisions
        Collisions of the ego since the last frame.
    """

    def __init__(self, message: str, collisions: tuple[Collision, ...] = ()):
        super().__init__(message)
        self.collisions = collisions


@dataclass(frozen=True, slots=True)
class EgoCommand:
    """Command to the ego. Each source accepts the fields that it supports and rejects others."""

    speed_mps: float | None = None
    """[m/s] Target speed, reached as soon as the vehicle can and then kept (SUMO)."""
    lane: int | None = None
    """Target lane, counted from the right, 0 first (SUMO)."""
    action: Any = None
    """Action of the environment: an index, or an array of indices or floats (highway-env)."""


@dataclass(frozen=True, slots=True)
class StartStatus:
    """Present activity of a source in its `reset`, for a progress bar."""

    activity: str
    share: float | None = None
    """Share that is done, 0 to 1; None if unknown."""
    file: str = ""
    """File that is read meanwhile, so that the position in it shows the progress."""
    process: int | None = None
    """Number of the process that reads it; None is this one."""


StartReport = Callable[[StartStatus], None]


def ignore_status(_: StartStatus) -> None:
    """Show nothing."""


def watch_start(source: object, report: StartReport) -> None:
    """Let a source report the progress of its `reset`; those that start at once report nothing."""
    if hasattr(source, "report_start"):
        source.report_start = report


class TrafficSource(Protocol):
    """A stream of `WorldFrame`s at a fixed rate.

    Frames are deterministic: the same seed and commands give the same frames, bit for bit. Call `reset` first; call it
    again to start a new run.
    """

    dt: float
    """Time between frames [s]."""
    origin: Floats
    """(2,) [m] origin of the world frame in the simulator's coordinates; valid after `reset`. Zero for small maps, else
    a multiple of 10 km, so that float32 resolves millimetres near the ego."""
    warnings: tuple[str, ...]
    """Defects of the input that the run survives, one line each with consequence and remedy; valid after `reset`."""
    ego_name: str
    """The ego's id in the simulator, valid after `reset`; empty if it has none."""

    def reset(self, seed: int) -> Obstacles:
        """Start a new run and return its static obstacles.

        Raises
        ------
        TrafficInputError
            The input does not exist or is out of range.
        SimulatorFailedError
            The simulator did not start.
        """
        ...

    def step(self) -> WorldFrame:
        """Return the next frame; the first call after `reset` returns frame 0.

        Raises
        ------
        TrafficEndedError
            There is no further frame: the ego is gone.
        SimulatorFailedError
            The simulator failed during the run.
        """
        ...

    def apply(self, command: EgoCommand) -> None:
        """Command the ego, effective from the next `step` until the next command.

        Raises
        ------
        TrafficInputError
            The command is not for this kind of traffic, or the source was not set up for a controlled ego.
        """
        ...

    def close(self) -> None:
        """Release the simulator. Safe to call twice, and without `reset`."""
        ...
