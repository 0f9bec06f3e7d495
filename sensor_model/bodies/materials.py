"""Reflectivity and transmission of surfaces at 905 nm: glass, paint, rubber, interiors."""

from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Bytes, Floats
from luxloop.sensor_model.truth import Part

TYRE_REFLECTIVITY = 0.05
"""Carbon-black rubber; an estimate, as for black paint."""


@dataclass(frozen=True, slots=True)
class Glass:
    """Windows: a weak echo of the pane, and one of the interior behind it.

    The values are estimates within physical ranges, chosen by point counts on 39 parked cars (docs/realism.md): 40
    to 65 % of the beams on real windows bring no echo.
    """

    pane_reflectivity: float = 0.01
    """Diffuse reflectivity of a pane, 0 to 1. Clean glass reflects about 8 % specularly, away from the unit (Fresnel,
    two faces of index 1.5), and scatters almost nothing; dirt and printed edges scatter 0.02 to 0.1."""
    transmission: float = 0.5
    """Share of the power that passes a pane once, 0 to 1; light passes twice. Tinted automotive glass absorbs near
    infrared. 0 makes windows opaque."""
    interior_reflectivity: float = 0.08
    """Diffuse reflectivity of seats and trim, 0 to 1."""
    interior_depth_m: float = 0.6
    """[m] Distance of the interior behind windscreen and rear window; half of it behind the side windows."""

    def __post_init__(self) -> None:
        shares = (self.pane_reflectivity, self.transmission, self.interior_reflectivity)
        if not all(0.0 <= share <= 1.0 for share in shares):
            raise ValueError("pane_reflectivity, transmission and interior_reflectivity must be from 0 to 1")
        if not 0.0 < self.interior_depth_m <= 1.0:
            raise ValueError(
                f"interior_depth_m = {self.interior_depth_m}: must be above 0 and at most 1 to fit the cabin"
            )


def plane_reflectivity(part: Bytes, paint: float, glass: Glass) -> Floats:
    """Return the diffuse reflectivity (Q,) of planes by `Part` (Q,), on an actor of this paint."""
    by_part = np.full(len(Part), paint)
    by_part[Part.GREENHOUSE] = glass.pane_reflectivity
    by_part[Part.WHEEL] = TYRE_REFLECTIVITY
    by_part[Part.INTERIOR] = glass.interior_reflectivity
    return by_part[part]


def plane_transmission(part: Bytes, glass: Glass) -> Floats:
    """Return the two-way power transmission (Q,) of planes by `Part` (Q,); 0 for all parts but panes."""
    return np.where(part == Part.GREENHOUSE, glass.transmission**2, 0.0)
