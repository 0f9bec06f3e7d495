"""Vehicles of some traffic, candidates for the ego among them, and their order."""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Bools, Floats, Ints
from luxloop.sim.candidates.want import Want


@dataclass(frozen=True, slots=True)
class Body:
    """Constant properties of a vehicle."""

    name: str
    """The simulator's id."""
    vehicle_class: str
    """The simulator's word for its class."""
    size: tuple[float, float]
    """Length, width [m]."""
    graded: bool
    """It counts as a neighbour: bicycles and people do not, since they are not graded."""
    rejected: bool = False
    """It cannot carry the rig."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """All vehicles on the road at one instant, N rows."""

    time: float
    """[s] on the simulator's clock."""
    new: list[Body]
    """Vehicles that appear for the first time, in the order of their numbers."""
    body: Ints
    """(N,) number of each vehicle, counted from 0 in the order of first appearance."""
    pose: Floats
    """(N, 3) box centre x [m], y [m], yaw [rad] in the simulator's coordinates."""
    speed: Floats
    """(N,) [m/s]."""


STAY_S = 30.0
"""[s] Default stay that a candidate needs; shorter ones come last."""
SLOWEST_MPS = 1.0
"""[m/s] A candidate that is slower on average is parked or in a blocked queue, and comes last, too."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """Vehicles of some traffic, N rows in the order of appearance, with S samples in all."""

    bodies: list[Body]
    """Name, class and size."""
    enters_s: Floats
    """(N,) first sample on the simulator's clock [s]."""
    stay_s: Floats
    """(N,) from the first sample to the last [s]."""
    leaves: Bools
    """(N,) False if it is still there at the last moment, so that it may stay longer."""
    distance_m: Floats
    """(N,) distance driven [m]."""
    neighbours: Floats
    """(N,) mean number of other vehicles in sensor range."""
    near: Floats
    """(N,) mean number of other vehicles within the range of grading."""
    turns: Floats
    """(N,) share of its stay in which it turns."""
    stops: Ints
    """(N,) number of times it comes to a stop."""
    occlusion: Floats
    """(N,) share of the samples of near vehicles whose line of sight is blocked by another vehicle."""
    first: Ints
    """(N,) first sample of each vehicle."""
    time: Floats
    """(S,) [s] on the simulator's clock, by vehicle and then by time."""
    near_at: Ints
    """(S,) other vehicles within the range of grading."""
    speed_at: Floats
    """(S,) [m/s]."""

    def __len__(self) -> int:
        return len(self.bodies)

    @property
    def suitable(self) -> Bools:
        """(N,) mask of vehicles that can carry the rig."""
        return np.array([not body.rejected for body in self.bodies], dtype=bool)

    def order(self, want: Want = Want.NEIGHBOURS, stay_s: float = STAY_S) -> Ints:
        """Return the vehicles (N,), the best first.

        Vehicles come first that can carry the rig, stay for `stay_s`, and drive at `SLOWEST_MPS` on average. Among
        these, the order is that of the wanted value: for `neighbours` the mean number within the range of grading, for
        `long` the stay. Equal vehicles are in the order of stay, entry and name.

        Parameters
        ----------
        want
            Wanted property.
        stay_s
            Stay that a candidate needs [s].
        """
        value = {
            Want.NEIGHBOURS: self.near,
            Want.TURNS: self.turns,
            Want.STOPS: self.stops,
            Want.OCCLUSION: self.occlusion,
            Want.LONG: self.stay_s,
        }[want]
        moves = self.distance_m >= SLOWEST_MPS * self.stay_s
        usable = self.suitable & moves & (self.stay_s >= stay_s)
        names = np.array([body.name for body in self.bodies], dtype=str)
        return np.lexsort((names, self.enters_s, -self.stay_s, -value, ~usable, ~self.suitable))

    def busiest_start(self, row: int, duration_s: float) -> tuple[float, float]:
        """Return the start [s] of the window with most near vehicles in the stay of a vehicle, and their mean number.

        Windows in which the vehicle drives at `SLOWEST_MPS` on average come first.

        Parameters
        ----------
        row
            The vehicle.
        duration_s
            Length of the window [s]; the whole stay if it is shorter.
        """
        end = self.first[row + 1] if row + 1 < len(self) else len(self.time)
        time, near, speed = (values[self.first[row] : end] for values in (self.time, self.near_at, self.speed_at))
        fits = np.flatnonzero(time + duration_s <= time[-1] + 1e-6)
        start = fits if len(fits) else np.array([0])
        last = np.searchsorted(time, time[start] + duration_s, side="right")
        total_near, total_speed = (np.append(0.0, np.cumsum(values)) for values in (near, speed))
        mean_near, mean_speed = ((total[last] - total[start]) / (last - start) for total in (total_near, total_speed))
        best = np.lexsort((start, -mean_near, mean_speed < SLOWEST_MPS))[0]
        return float(time[start[best]]), float(mean_near[best])
