"""What surfaces send back and let through, at 905 nm: glass, paint, rubber, interiors."""

from dataclasses import dataclass

import numpy as np

from sensor_model.arrays import Bytes, Floats
from sensor_model.truth import Part

TYRE_REFLECTIVITY = 0.05
"""Carbon-black rubber; an estimate, as for black paint."""


@dataclass(frozen=True, slots=True)
class Glass:
    """Windows: a weak echo of the pane, and what is behind it. All values are engineering estimates."""

    pane_reflectivity: float = 0.06
    """Diffuse reflectivity of a pane, 0 to 1. Clean glass mirrors some 8 % away from the unit (Fresnel, two faces of
    index 1.5) and scatters next to nothing; dirt and printed edges scatter 0.02 to 0.1."""
    transmission: float = 0.8
    """Share of the power that one passage leaves, 0 to 1; light passes twice. 0 makes windows opaque."""
    interior_reflectivity: float = 0.2
    """Diffuse reflectivity of seats and trim, 0 to 1."""
    interior_depth_m: float = 0.6
    """[m] How far behind windscreen and rear window the interior begins; half of it behind the side windows."""

    def __post_init__(self) -> None:
        shares = (self.pane_reflectivity, self.transmission, self.interior_reflectivity)
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise ValueError("pane_reflectivity, transmission and interior_reflectivity are shares: write 0 to 1")
        if not 0.0 < self.interior_depth_m <= 1.0:
            raise ValueError("interior_depth_m must be above 0 and at most 1, or the interior would not fit the cabin")


def plane_reflectivity(part: Bytes, paint: float, glass: Glass) -> Floats:
    """Diffuse reflectivity (Q,) of planes of these parts (Q,) on an actor of this paint."""
    by_part = np.full(len(Part), paint)
    by_part[Part.GREENHOUSE] = glass.pane_reflectivity
    by_part[Part.WHEEL] = TYRE_REFLECTIVITY
    by_part[Part.INTERIOR] = glass.interior_reflectivity
    return by_part[part]


def plane_transmission(part: Bytes, glass: Glass) -> Floats:
    """Two-way power transmission (Q,) of planes of these parts (Q,): that of a pane passed twice, else 0."""
    return np.where(part == Part.GREENHOUSE, glass.transmission**2, 0.0)
