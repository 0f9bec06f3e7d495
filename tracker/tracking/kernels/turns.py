"""Integrals over a turn. Vectors are complex numbers x + iy."""

import cmath

import numpy as np
import numpy.typing as npt

from luxloop.tracker.compiled import kernel

Complexes = npt.NDArray[np.complex128]

LEAST_SPEED_MPS = 0.3
"""Speed below which the direction and the curvature of a motion are not known [m/s]."""

SMALL_ANGLE = 1e-3
"""Angle below which integrals over a turn use their series [rad]; the next term is below 1e-9 of the result."""


@kernel()
def turned_integrals(rate: float, end: float) -> tuple[complex, complex]:
    """Integrals of exp(i rate t) and of t exp(i rate t) from 0 to `end`."""
    angle = rate * end
    if abs(angle) < SMALL_ANGLE:
        first = end * (1.0 + 0.5j * angle - angle**2 / 6)
        return first, end**2 * (0.5 + 1j * angle / 3 - angle**2 / 8)
    last = cmath.exp(1j * rate * end)
    first = (last - 1.0) / (1j * rate)
    return first, (end * last - first) / (1j * rate)
