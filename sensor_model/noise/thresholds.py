"""What it takes to be seen."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Losses = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Thresholds:
    """What the B beams of one frame need. Not to be written to: frames may share the arrays."""

    threshold: Floats
    """(B,) power of the weakest echo that is seen [1/m^2]; infinite where none is."""
    own: Floats
    """(B,) what it would be in a clean, shaded and working unit [1/m^2]."""
    reason: Losses
    """(B,) the `Loss` that raised it, THRESHOLD where nothing did."""
    firing: Bools
    """(B,) the beam's fan fires in this frame, and its unit is not silent."""
