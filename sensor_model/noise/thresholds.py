"""Detection thresholds of the beams of one frame."""

from dataclasses import dataclass

from luxloop.arrays import Bools, Bytes, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Thresholds:
    """Detection thresholds of B beams in one frame. Read-only: frames may share the arrays."""

    threshold: Floats
    """(B,) minimum power of an echo [1/m^2]; infinite for a blind beam."""
    nominal: Floats
    """(B,) threshold in a clean, shaded and working unit [1/m^2]."""
    gain: Floats
    """(B,) sensitivity under sun glare, 1 in the shade."""
    transmission: Floats
    """(B,) two-way power transmission of the window, 1 where it is clean."""
    blind: Bytes
    """(B,) OUTAGE or RANDOM for a beam that detects no echo of any power, else THRESHOLD."""
    firing: Bools
    """(B,) True if the beam's fan fires in this frame and its unit is not silent."""
