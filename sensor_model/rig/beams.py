"""Beam table of a rig: origin, direction, firing time and sensitivity of each beam."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from luxloop import elementwise
from luxloop.arrays import Bytes, Floats, Ints
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.sensor_model.rig.unit import Fan, UnitModel


@dataclass(frozen=True, slots=True, eq=False)
class UnitTable:
    """U units as placed by the rig file."""

    origin_ego: Floats
    """(U, 3) position of each unit [m]."""
    R_ego_unit: Floats
    """(U, 3, 3) rotation of each unit: ego = R unit."""
    range_min: Floats
    """(U,) surfaces nearer than this block the beam and give no echo [m]."""
    range_max: Floats
    """(U,) [m]."""
    threshold: Floats
    """(U,) power of the weakest echo, reflectivity x cos(incidence) x gain / range^2 [1/m^2]."""
    pulse_length: Floats
    """(U,) returns within this difference in range are summed [m]."""
    pulse_growth: Floats
    """(U,) growth of the echo pulse width with the power relative to the threshold [m/dB]."""
    pulse_quantum: Floats
    """(U,) step of the echo pulse width [m]."""
    pulse_sigma: Floats
    """(U,) standard deviation of an echo pulse width [m]."""
    echo_separation: Floats
    """(U,) echoes that start closer to each other than this are merged [m]."""
    echoes_max: Ints
    """(U,) maximum number of echoes per beam."""
    beam_width: Floats
    """(U,) footprint over azimuth, edge to edge [rad]."""
    beam_height: Floats
    """(U,) footprint over elevation, edge to edge [rad]."""
    reference_range: Floats
    """(U,) range at which a surface of the model's reference reflectivity is at the threshold [m]."""
    range_sigma: Floats
    """(U,) standard deviation of a range near the unit [m]."""
    range_sigma_far: Floats
    """(U,) standard deviation of a range at `reference_range` [m]."""
    range_quantum: Floats
    """(U,) step of the range [m]."""

    def __len__(self) -> int:
        return len(self.range_min)


@dataclass(frozen=True, slots=True, eq=False)
class BeamTable:
    """B nominal beams of U units, ordered by unit, fan, layer and firing order (left to right).

    Beams of one unit, fan and layer form a row. Their azimuths are evenly spaced, so that the caster can compute the
    beams that may hit an object. There are R rows of F fans, ordered like the beams; the rows of a fan are its layers
    and have the same azimuths.
    """

    unit: Bytes
    """(B,) index of the unit in the rig."""
    layer: Bytes
    """(B,) 0 is the lowest."""
    index: npt.NDArray[np.int32]
    """(B,) index of the beam in its unit."""
    azimuth: Floats
    """(B,) in the unit's frame, left positive [rad]."""
    elevation: Floats
    """(B,) in the unit's frame, up positive [rad]."""
    time_offset: Floats
    """(B,) firing time relative to the frame's time [s]."""
    gain: Floats
    """(B,) sensitivity, 1 at the centre of the unit."""
    layer_bias: Floats
    """(B,) fixed range error [m]."""
    layer_pulse_bias: Floats
    """(B,) fixed error of the echo pulse width [m]."""
    direction_ego: Floats
    """(B, 3) unit vectors."""
    row_beam: Ints
    """(R + 1,) row r holds beams row_beam[r] to row_beam[r + 1]."""
    fan_unit: Ints
    """(F,) unit of the fan."""
    fan_row: Ints
    """(F + 1,) fan f has rows fan_row[f] to fan_row[f + 1]."""
    fan_azimuth: Floats
    """(F, 2) first azimuth, and step, negative because the sweep runs to the right [rad]."""
    fan_turn: Ints
    """(F, 2) turn and turns: the fan fires in frames whose index % turns == turn."""
    units: UnitTable

    def __len__(self) -> int:
        return len(self.unit)


def beam_table(rig: Rig) -> BeamTable:
    """Return the beam table of a rig.

    A beam of azimuth h [rad] fires at phase - h / (2 pi scan rate): the mirror rotates evenly, once per scan.
    Behind a mirror face of tilt b its elevation is that of its layer plus b (-sqrt(2) sin(h / 2 - pi / 4) - 1),
    which is 0 at h = 0 (SICK LD-MRS and LUX 8L, as the driver `libsick_ldmrs` computes it).
    """
    units = unit_table(rig)
    fans = [(unit, mount, fan) for unit, mount in enumerate(rig.mounts) for fan in mount.model.fans]
    rows = [(unit, mount, fan, layer) for unit, mount, fan in fans for layer in fan.layers]
    beams = np.array([fan.count for _, _, fan, _ in rows])
    unit = np.repeat([unit for unit, _, _, _ in rows], beams)
    azimuth = np.concatenate([_azimuth(fan) for _, _, fan, _ in rows])
    elevation = np.concatenate([_elevation(mount.model, fan, layer) for _, mount, fan, layer in rows])
    phase = np.array([mount.phase_ms / 1000.0 for mount in rig.mounts])
    return BeamTable(
        unit=unit.astype(np.uint8),
        layer=np.repeat([layer for _, _, _, layer in rows], beams).astype(np.uint8),
        index=np.concatenate([np.arange(count, dtype=np.int32) for count in np.bincount(unit)]),
        azimuth=azimuth,
        elevation=elevation,
        time_offset=phase[unit] - azimuth / (2.0 * np.pi * rig.scan_rate_hz),
        gain=np.concatenate([_gain(mount.model, fan) for _, mount, fan, _ in rows]),
        layer_bias=np.repeat([mount.model.layer_bias_m[layer] for _, mount, _, layer in rows], beams),
        layer_pulse_bias=np.repeat([mount.model.layer_pulse_bias_m[layer] for _, mount, _, layer in rows], beams),
        direction_ego=elementwise.product(units.R_ego_unit[unit], _unit_vector(azimuth, elevation)[:, :, None])[
            :, :, 0
        ],
        row_beam=np.cumsum([0, *beams], dtype=np.int64),
        fan_unit=np.array([unit for unit, _, _ in fans], dtype=np.int64),
        fan_row=np.cumsum([0, *(len(fan.layers) for _, _, fan in fans)], dtype=np.int64),
        fan_azimuth=np.deg2rad([(fan.start_deg, -fan.step_deg) for _, _, fan in fans]),
        fan_turn=np.array([(fan.turn, mount.model.turns) for _, mount, fan in fans], dtype=np.int64),
        units=units,
    )


def sweep_limits(beams: BeamTable) -> npt.NDArray[np.float32]:
    """Return (U, L, 2) firing times of the first and the last beam of each layer, NaN for layers a unit lacks [s]."""
    shape = (len(beams.units), int(beams.layer.max()) + 1)
    first, last = np.full(shape, np.inf), np.full(shape, -np.inf)
    np.minimum.at(first, (beams.unit, beams.layer), beams.time_offset)
    np.maximum.at(last, (beams.unit, beams.layer), beams.time_offset)
    limits = np.stack([first, last], axis=2)
    return np.where(np.isfinite(limits), limits, np.nan).astype(np.float32)


def unit_table(rig: Rig) -> UnitTable:
    """Return poses and receivers of the units of a rig."""
    models = [mount.model for mount in rig.mounts]
    return UnitTable(
        origin_ego=np.array([(rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m) for mount in rig.mounts]),
        R_ego_unit=np.stack([_rotation(mount) for mount in rig.mounts]),
        range_min=np.array([model.range_min_m for model in models]),
        range_max=np.array([model.range_max_m for model in models]),
        threshold=np.array([model.reference_reflectivity / model.reference_range_m**2 for model in models]),
        pulse_length=np.array([model.pulse_length_m for model in models]),
        pulse_growth=np.array([model.pulse_growth_m_per_db for model in models]),
        pulse_quantum=np.array([model.pulse_quantum_m for model in models]),
        pulse_sigma=np.array([model.pulse_sigma_m for model in models]),
        echo_separation=np.array([model.echo_separation_m for model in models]),
        echoes_max=np.array([model.echoes_max for model in models], dtype=np.int64),
        beam_width=np.deg2rad([model.beam_width_deg for model in models]),
        beam_height=np.deg2rad([model.beam_height_deg for model in models]),
        reference_range=np.array([model.reference_range_m for model in models]),
        range_sigma=np.array([model.range_sigma_m for model in models]),
        range_sigma_far=np.array([model.range_sigma_far_m for model in models]),
        range_quantum=np.array([model.range_quantum_m for model in models]),
    )


def _rotation(mount: Mount) -> Floats:
    """Return (3, 3) ego = R unit: yaw about z, then pitch about the new y, then roll about the new x."""
    angles_deg = [mount.yaw_deg, mount.pitch_deg, mount.roll_deg]
    return np.asarray(scipy.spatial.transform.Rotation.from_euler("ZYX", angles_deg, degrees=True).as_matrix())


def _azimuth(fan: Fan) -> Floats:
    """Return (K,) azimuths of one layer of the fan in firing order [rad]."""
    first, step = np.deg2rad([fan.start_deg, -fan.step_deg])
    azimuth: Floats = first + step * np.arange(fan.count)
    return azimuth


def _elevation(model: UnitModel, fan: Fan, layer: int) -> Floats:
    """Return (K,) elevations of one layer's beams [rad]."""
    tilted = -np.sqrt(2.0) * elementwise.sin(_azimuth(fan) / 2.0 - np.pi / 4.0) - 1.0
    elevation: Floats = np.deg2rad(model.layer_elevation_deg[layer] + fan.tilt_deg * tilted)
    return elevation


def _gain(model: UnitModel, fan: Fan) -> Floats:
    """Return (K,) gain of one layer's beams, linear between the knots, whose azimuths fall."""
    azimuth_deg = fan.start_deg - fan.step_deg * np.arange(fan.count)
    gain: Floats = np.interp(-azimuth_deg, -np.array(model.gain_azimuth_deg), np.array(fan.gain_percent) / 100.0)
    return gain


def _unit_vector(azimuth: Floats, elevation: Floats) -> Floats:
    """Return (B, 3) directions in the unit's frame."""
    cos = elementwise.cos(elevation)
    return np.stack(
        [cos * elementwise.cos(azimuth), cos * elementwise.sin(azimuth), elementwise.sin(elevation)], axis=1
    )
