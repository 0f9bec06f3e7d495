"""Dirt on the window of a unit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from luxloop.arrays import Floats
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.rig.unit_names import ALL_UNITS, unit_rows

_ROUNDING = 1e-9  # [rad] tolerance that keeps beams on the edges of a sector inside


@dataclass(frozen=True, slots=True)
class DirtSector:
    """Dirty sector of a unit's window, over all its layers."""

    unit: str
    """Name of the unit in the rig file, or * for all units."""
    from_deg: float
    """[deg] Right edge: azimuth in the unit's frame, left positive."""
    to_deg: float
    """[deg] Left edge. Sectors on cars are 5 to 30 degrees wide; an estimate."""
    transmission: float = 0.5
    """Share of the power that passes the window once, 0 to 1; light passes twice. An estimate."""

    def __post_init__(self) -> None:
        if not self.from_deg < self.to_deg:
            raise ValueError(
                f"to_deg = {self.to_deg}: must be above from_deg = {self.from_deg}; azimuth grows to the left"
            )
        for name in ("from_deg", "to_deg"):
            if not -180.0 <= getattr(self, name) <= 180.0:
                raise ValueError(
                    f"{name} = {getattr(self, name)}: must be from -180 to 180; split a sector that crosses the rear"
                )
        if not 0.0 <= self.transmission <= 1.0:
            raise ValueError(f"transmission = {self.transmission}: must be from 0 (opaque) to 1 (no dirt)")


@dataclass(frozen=True, slots=True)
class Dirt:
    """Dirty windows, which reduce the power of echoes and thereby the detection range."""

    enabled: bool = False
    """If false, all windows are clean."""
    sectors: tuple[DirtSector, ...] = (DirtSector(ALL_UNITS, from_deg=-10.0, to_deg=10.0),)
    """Dirty sectors; the default is a sector about the centre of every unit."""

    def __post_init__(self) -> None:
        if self.enabled and not self.sectors:
            raise ValueError("sectors = []: dirt is enabled; name at least one sector")


def window_transmission(config: Dirt, beams: BeamTable, unit_names: Sequence[str]) -> Floats:
    """Return the (B,) two-way power transmission of the window per beam, transmission^2.

    Raises
    ------
    ValueError
        A sector names a unit that the rig does not have.
    """
    passed = np.ones(len(beams))
    for sector in config.sectors if config.enabled else ():
        of_unit = np.isin(beams.unit, unit_rows(sector.unit, unit_names))
        right, left = np.deg2rad([sector.from_deg, sector.to_deg])
        dirty = of_unit & (beams.azimuth >= right - _ROUNDING) & (beams.azimuth <= left + _ROUNDING)
        passed[dirty] *= sector.transmission**2
    return passed
