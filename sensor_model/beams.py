"""The beam table of a rig: where every beam starts, where it goes, and how sensitive it is."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from sensor_model.rig import Mount, Rig
from sensor_model.unit import Fan, UnitModel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BeamTable:
    """B beams of U units, ordered by unit, fan, layer and firing order (left to right).

    Beams of one unit, fan and layer make a row: their azimuths are evenly spaced, so that the caster can go
    straight to the beams that may meet a thing. R rows, ordered like the beams.
    """

    unit: npt.NDArray[np.uint8]
    """(B,) index of the unit in the rig."""
    layer: npt.NDArray[np.uint8]
    """(B,) 0 is the lowest."""
    index: npt.NDArray[np.int32]
    """(B,) index of the beam in its unit."""
    azimuth: Floats
    """(B,) in the unit's frame, left positive [rad]."""
    elevation: Floats
    """(B,) in the unit's frame, up positive [rad]."""
    direction_ego: Floats
    """(B, 3) unit vectors."""
    gain: Floats
    """(B,) sensitivity, 1 at the unit's centre."""
    layer_bias: Floats
    """(B,) fixed range error [m]."""
    range_min: Floats
    """(B,) [m]."""
    range_max: Floats
    """(B,) [m]."""
    pulse_length: Floats
    """(B,) [m]."""
    origin_ego: Floats
    """(U, 3) where each unit is [m]."""
    R_ego_unit: Floats
    """(U, 3, 3) rotation of each unit: ego = R unit."""
    unit_row: Ints
    """(U + 1,) unit u has rows unit_row[u] to unit_row[u + 1]."""
    row_beam: Ints
    """(R + 1,) row r holds beams row_beam[r] to row_beam[r + 1]."""
    row_azimuth: Floats
    """(R, 2) first azimuth and signed step of each row [rad]."""

    def __len__(self) -> int:
        return len(self.unit)


def beam_table(rig: Rig) -> BeamTable:
    """Lay out every beam of the rig."""
    rows = [
        (unit, mount.model, fan, layer)
        for unit, mount in enumerate(rig.mounts)
        for fan in mount.model.fans
        for layer in fan.layers
    ]
    row_unit = np.array([unit for unit, _, _, _ in rows])
    row_azimuth = np.deg2rad([(fan.start_deg, -fan.step_deg) for _, _, fan, _ in rows])
    row_beam = np.cumsum([0, *(fan.count for _, _, fan, _ in rows)], dtype=np.int64)
    unit_row = np.searchsorted(row_unit, np.arange(len(rig.mounts) + 1)).astype(np.int64)

    row = np.repeat(np.arange(len(rows)), np.diff(row_beam))
    unit = row_unit[row]
    azimuth = row_azimuth[row, 0] + row_azimuth[row, 1] * (np.arange(len(row)) - row_beam[row])
    elevation = np.deg2rad([model.layer_elevation_deg[layer] for _, model, _, layer in rows])[row]
    R_ego_unit = np.stack([_rotation(mount) for mount in rig.mounts])
    return BeamTable(
        unit=unit.astype(np.uint8),
        layer=np.array([layer for _, _, _, layer in rows], dtype=np.uint8)[row],
        index=(np.arange(len(row)) - row_beam[unit_row[unit]]).astype(np.int32),
        azimuth=azimuth,
        elevation=elevation,
        direction_ego=np.einsum("bij,bj->bi", R_ego_unit[unit], _unit_vector(azimuth, elevation)),
        gain=np.concatenate([_row_gain(model, fan) for _, model, fan, _ in rows]),
        layer_bias=np.array([model.layer_bias_m[layer] for _, model, _, layer in rows])[row],
        range_min=np.array([model.range_min_m for _, model, _, _ in rows])[row],
        range_max=np.array([model.range_max_m for _, model, _, _ in rows])[row],
        pulse_length=np.array([model.pulse_length_m for _, model, _, _ in rows])[row],
        origin_ego=np.array([(rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m) for mount in rig.mounts]),
        R_ego_unit=R_ego_unit,
        unit_row=unit_row,
        row_beam=row_beam,
        row_azimuth=row_azimuth,
    )


def _rotation(mount: Mount) -> Floats:
    """(3, 3) ego = R unit: yaw about z, then pitch about the turned y, then roll about the turned x."""
    angles_deg = [mount.yaw_deg, mount.pitch_deg, mount.roll_deg]
    return np.asarray(Rotation.from_euler("ZYX", angles_deg, degrees=True).as_matrix())


def _unit_vector(azimuth: Floats, elevation: Floats) -> Floats:
    """(B, 3) directions in the unit's frame."""
    cos = np.cos(elevation)
    return np.stack([cos * np.cos(azimuth), cos * np.sin(azimuth), np.sin(elevation)], axis=1)


def _row_gain(model: UnitModel, fan: Fan) -> Floats:
    """(K,) gain of one layer's beams, linear between the knots, which fall from left to right."""
    azimuth_deg = fan.start_deg - fan.step_deg * np.arange(fan.count)
    gain: Floats = np.interp(-azimuth_deg, -np.array(model.gain_azimuth_deg), np.array(fan.gain_percent) / 100.0)
    return gain
