"""What it takes to be seen."""

from dataclasses import dataclass

from sensor_model.arrays import Bools, Bytes, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Thresholds:
    """What the B beams of one frame need. Not to be written to: frames may share the arrays."""

    threshold: Floats
    """(B,) power of the weakest echo that is seen [1/m^2]; infinite where none is."""
    own: Floats
    """(B,) what it would be in a clean, shaded and working unit [1/m^2]."""
    gain: Floats
    """(B,) sensitivity in the sun, 1 in the shade."""
    passed: Floats
    """(B,) share of the power that passes the window out and back, 1 where it is clean."""
    blind: Bytes
    """(B,) OUTAGE or RANDOM where no echo is seen, however strong; THRESHOLD elsewhere."""
    firing: Bools
    """(B,) the beam's fan fires in this frame, and its unit is not silent."""
