"""The true motion mode of every actor, frame by frame: whether it stands, keeps its velocity or accelerates."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.arrays import Bools, Floats, Ints
from sim.world import Mode

_NO, _YES, _UNKNOWN = range(3)

States = npt.NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ModeLimits:
    """When an actor's motion mode changes. Each pair is a Schmitt trigger, so that nothing flickers at its limit.

    An actor that has just appeared has no mode to stick to: the middle of each pair decides.
    """

    moves_from_mps: float = 0.5
    """[m/s] An actor that stands begins to move at this speed: a walker's is three times that, and in a scan of 0.08 s
    it makes 0.04 m, so little that a LIDAR with 0.1 m of noise needs some scans to see it."""
    stands_below_mps: float = 0.3
    """[m/s] An actor that moves stands again below this speed."""
    accelerates_from_mps2: float = 0.6
    """[m/s^2] An actor of steady velocity begins to accelerate at this norm of its acceleration vector, to which a turn
    adds speed times yaw rate. It leaves a straight course at steady speed by 0.1 m, the noise of a LIDAR, in 0.6 s. A
    lane change of 3.5 m in 4 s reaches 1.1 m/s^2; a motorway's bend of 2 km radius at 30 m/s has 0.45 m/s^2."""
    steady_below_mps2: float = 0.4
    """[m/s^2] An actor that accelerates is of steady velocity again below this."""

    def __post_init__(self) -> None:
        pairs = (("stands_below_mps", "moves_from_mps"), ("steady_below_mps2", "accelerates_from_mps2"))
        for low, high in pairs:
            if not 0 < getattr(self, low) <= getattr(self, high):
                raise ValueError(
                    f"{low} = {getattr(self, low)} must be above 0 and no higher than {high} = {getattr(self, high)}"
                )


class ModeJudge:
    """Judges one run, frame after frame; it knows the past only.

    Parameters
    ----------
    limits
        When modes change.
    """

    def __init__(self, limits: ModeLimits):
        self._move = _trigger(limits.stands_below_mps, limits.moves_from_mps)
        self._accelerate = _trigger(limits.steady_below_mps2, limits.accelerates_from_mps2)
        self._id = np.empty(0, dtype=np.int64)
        self._moves = np.empty(0, dtype=np.intp)
        self._accelerates = np.empty(0, dtype=np.intp)

    def modes(self, id: Ints, velocity_world: Floats, acceleration_world: Floats) -> npt.NDArray[np.uint8]:
        """Return the `Mode` (N,) of each actor present; one that was not in the frame before starts anew.

        Parameters
        ----------
        id
            (N,) ascending.
        velocity_world, acceleration_world
            (N, 2) [m/s] and [m/s^2].
        """
        before, known = self._rows_before(id)
        self._moves = _switched(self._moves, before, known, np.hypot(*velocity_world.T), self._move)
        self._accelerates = _switched(
            self._accelerates, before, known, np.hypot(*acceleration_world.T), self._accelerate
        )
        self._id = id
        # An acceleration counts in motion only: what stands and rocks is stationary.
        moving = np.where(self._accelerates == _YES, Mode.ACCELERATING, Mode.CONSTANT_VELOCITY)
        return np.where(self._moves == _YES, moving, Mode.STATIONARY).astype(np.uint8)

    def _rows_before(self, id: Ints) -> tuple[Ints, Bools]:
        """Rows (N,) of the actors in the frame before, and whether they were there (N,)."""
        if not len(self._id):
            return np.zeros(len(id), dtype=np.int64), np.zeros(len(id), dtype=np.bool_)
        row = np.minimum(np.searchsorted(self._id, id), len(self._id) - 1)
        return row, self._id[row] == id


def _trigger(low: float, high: float) -> Floats:
    """Thresholds (3,) of a Schmitt trigger, by the state it is in."""
    return np.array([high, low, (low + high) / 2])


def _switched(state: States, before: Ints, known: Bools, value: Floats, trigger: Floats) -> States:
    """States (N,) of triggers that were in `state` (rows `before`, where `known`) and now see `value` (N,)."""
    last = np.full(len(value), _UNKNOWN, dtype=np.intp)
    last[known] = state[before[known]]
    return np.where(value >= trigger[last], _YES, _NO).astype(np.intp)
