"""True motion mode of every actor, frame by frame: stationary, constant velocity or accelerating."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop import elementwise
from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.world import Mode

_OFF, _ON, _UNKNOWN = range(3)

States = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ModeLimits:
    """Thresholds of the motion modes. Each pair is a Schmitt trigger, so that modes do not flicker at a limit.

    A new actor has no previous mode: the middle of each pair is its threshold.
    """

    moves_from_mps: float = 0.5
    """[m/s] A stationary actor starts to move at this speed. A pedestrian walks three times as fast. In a scan of 0.08
    s this speed covers 0.04 m, so a LIDAR with 0.1 m of noise needs several scans to detect the motion."""
    stands_below_mps: float = 0.3
    """[m/s] A moving actor becomes stationary below this speed."""
    accelerates_from_mps2: float = 0.6
    """[m/s^2] An actor of constant velocity becomes accelerating at this norm of its acceleration vector, which
    includes the centripetal acceleration (speed times yaw rate) of a turn. At this value it leaves a constant-velocity
    course by 0.1 m, the noise of a LIDAR, in 0.6 s. A lane change of 3.5 m in 4 s reaches 1.1 m/s^2; a motorway bend of
    2 km radius at 30 m/s has 0.45 m/s^2."""
    steady_below_mps2: float = 0.4
    """[m/s^2] An accelerating actor returns to constant velocity below this norm."""

    def __post_init__(self) -> None:
        pairs = (("stands_below_mps", "moves_from_mps"), ("steady_below_mps2", "accelerates_from_mps2"))
        for low, high in pairs:
            if not 0 < getattr(self, low) <= getattr(self, high):
                raise ValueError(
                    f"{low} = {getattr(self, low)} must be above 0 and no higher than {high} = {getattr(self, high)}"
                )


class ModeClassifier:
    """Causal classifier of the motion modes of one run, frame by frame.

    Parameters
    ----------
    limits
        Thresholds of the modes.
    """

    def __init__(self, limits: ModeLimits):
        self._move = _thresholds(limits.stands_below_mps, limits.moves_from_mps)
        self._accelerate = _thresholds(limits.steady_below_mps2, limits.accelerates_from_mps2)
        self._id = np.empty(0, dtype=np.int64)
        self._moves = np.empty(0, dtype=np.intp)
        self._accelerates = np.empty(0, dtype=np.intp)

    def modes(self, id: Ints, velocity_world: Floats, acceleration_world: Floats) -> npt.NDArray[np.uint8]:
        """Return the `Mode` (N,) of each actor; an actor that was absent from the previous frame has no history.

        Parameters
        ----------
        id
            (N,) ascending.
        velocity_world, acceleration_world
            (N, 2) [m/s] and [m/s^2].
        """
        before, known = self._previous_rows(id)
        self._moves = _next_state(self._moves, before, known, elementwise.hypot(*velocity_world.T), self._move)
        self._accelerates = _next_state(
            self._accelerates, before, known, elementwise.hypot(*acceleration_world.T), self._accelerate
        )
        self._id = id
        # Acceleration counts only while moving: an actor that rocks in place is stationary.
        moving = np.where(self._accelerates == _ON, Mode.ACCELERATING, Mode.CONSTANT_VELOCITY)
        return np.where(self._moves == _ON, moving, Mode.STATIONARY).astype(np.uint8)

    def _previous_rows(self, id: Ints) -> tuple[Ints, Bools]:
        """Return the rows (N,) of the actors in the previous frame, and a mask (N,) of those that were in it."""
        if not len(self._id):
            return np.zeros(len(id), dtype=np.int64), np.zeros(len(id), dtype=np.bool_)
        row = np.minimum(np.searchsorted(self._id, id), len(self._id) - 1)
        return row, self._id[row] == id


def _thresholds(low: float, high: float) -> Floats:
    """Return the thresholds (3,) of a Schmitt trigger, indexed by its state."""
    return np.array([high, low, (low + high) / 2])


def _next_state(state: States, before: Ints, known: Bools, value: Floats, trigger: Floats) -> States:
    """Return the states (N,) of triggers with input `value` (N,), given `state` at rows `before` where `known`."""
    last = np.full(len(value), _UNKNOWN, dtype=np.intp)
    last[known] = state[before[known]]
    return np.where(value >= trigger[last], _ON, _OFF).astype(np.intp)
