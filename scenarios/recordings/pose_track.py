"""Poses of a body over time: interpolation and derivatives of measured poses."""

import math
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError

GAP_S = 0.5
"""[s] Longest interval between two poses that is interpolated. Motion capture loses hidden bodies for longer."""
WINDOW_S = 0.3
"""[s] Half width of the window of the derivatives: a jerk of 2 m/s^3, hard braking, changes the acceleration at its
edge by 0.6 m/s^2, the limit of `luxloop.sim.modes`, and at 40 poses per second 5 mm of noise leave 0.006 m/s."""
LARGEST_ROW = np.array([1e11, 1e7, 1e7, 1e7])
"""Absolute values of time [s], x, y [m] and yaw [rad], as of recorded scans."""
LEAST_POSES = 4
"""A parabola through fewer poses has no residual."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion of a body at one time, in the frame of its poses."""

    pose: Floats
    """(3,) x [m], y [m], yaw [rad]."""
    velocity: Floats
    """(2,) [m/s]."""
    acceleration: Floats
    """(2,) [m/s^2]."""
    yaw_rate: float
    """[rad/s]."""


class PoseTrack:
    """Poses of a body.

    Parameters
    ----------
    rows
        (M, 4) time [s], x [m], y [m], yaw [rad], in any order; of poses with equal times, the first counts.
    gap_s, hold_s
        Longest interval between two poses that is interpolated, and how long the first and the last pose hold before
        and after their times [s].
    window_s
        Half width of the window of the derivatives [s].

    Raises
    ------
    InputError
        A number is beyond `LARGEST_ROW`.
    """

    def __init__(
        self, rows: Floats, gap_s: float = GAP_S, hold_s: float = 0.5 * GAP_S, window_s: float = WINDOW_S
    ) -> None:
        self._gap_s, self._hold_s, self._window_s = gap_s, hold_s, window_s
        kept = rows[np.isfinite(rows).all(axis=1)]
        if (np.abs(kept) > LARGEST_ROW).any():
            raise InputError("a pose of a body has a number that none has; the recording is damaged")
        _, first = np.unique(kept[:, 0], return_index=True)
        kept = kept[first]
        self._time: Floats = kept[:, 0]
        self._values: Floats = np.column_stack([kept[:, 1:3], np.unwrap(kept[:, 3])])

    def __len__(self) -> int:
        return len(self._time)

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last pose [s]; NaN without poses."""
        return (float(self._time[0]), float(self._time[-1])) if len(self) else (math.nan, math.nan)

    def at(self, time: float) -> Floats | None:
        """Return the pose (3,) at a time [s] by linear interpolation, or None in a gap."""
        if not len(self):
            return None
        after = int(np.searchsorted(self._time, time))
        if 0 < after < len(self) and self._time[after] != time:
            near = self._time[after] - self._time[after - 1] <= self._gap_s
        else:
            near = abs(self._time[min(after, len(self) - 1)] - time) <= self._hold_s
        if not near:
            return None
        return np.array([np.interp(time, self._time, column) for column in self._values.T])

    def motion(self, time: float) -> Motion | None:
        """Return the motion at a time [s], or None in a gap.

        Position and yaw are interpolated. Derivatives are those of the least-squares parabola through the poses within
        the window; with fewer than `LEAST_POSES` of them the body stands still.
        """
        pose = self.at(time)
        if pose is None:
            return None
        low, high = np.searchsorted(self._time, [time - self._window_s, time + self._window_s])
        if high - low < LEAST_POSES:
            return Motion(pose, np.zeros(2), np.zeros(2), 0.0)
        t = self._time[low:high] - time
        fit: Floats = np.polynomial.polynomial.polyfit(t, self._values[low:high], 2).astype(np.float64)
        return Motion(pose, fit[1, :2], 2.0 * fit[2, :2], float(fit[1, 2]))
