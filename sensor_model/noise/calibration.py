"""Calibration errors: deviations of mounting poses and firing times from their nominal values."""

from dataclasses import dataclass

import numpy as np
import scipy

from luxloop import elementwise
from luxloop.arrays import Bools, Bytes, Floats, Ints
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.beams import UnitTable

_RUN = 0  # frame number of draws made once per run


@dataclass(frozen=True, slots=True)
class CalibrationError:
    """Residual errors of a good calibration.

    Points are computed with the nominal pose and time, so that a contour seen by two units is doubled.

    The strengths are those of a static calibration with targets: biases of 1 cm, as between the layers of a LUX, over a
    wall of 5 m are 0.1 degrees. The LUX's protocol transmits mounting angles in steps of 1/32 degree and positions in
    centimetres. Calibration without targets is worse: 0.04 rad and 0.1 m by Jiao et al. (2019, "Automatic Calibration
    of Multiple 3D LiDARs in Urban Environments").
    """

    enabled: bool = True
    """If false, poses and times are exact."""
    yaw_sigma_deg: float = 0.1
    """[deg] Standard deviation of a unit's yaw error, constant over a run."""
    pitch_sigma_deg: float = 0.1
    """[deg] Standard deviation of a unit's pitch error, constant over a run."""
    roll_sigma_deg: float = 0.1
    """[deg] Standard deviation of a unit's roll error, constant over a run."""
    xy_sigma_m: float = 0.02
    """[m] Standard deviation of the error of a unit's horizontal coordinates, constant over a run."""
    z_sigma_m: float = 0.01
    """[m] Standard deviation of a unit's height error, constant over a run."""
    sync_sigma_ms: float = 1.0
    """[ms] Standard deviation of a unit's firing time error, drawn per frame and unit. Clocks set by a telegram are off
    by up to a few milliseconds (SICK LD-LRS operating instructions 8016506, clock synchronisation); a synchronisation
    pulse would be better."""
    doubled_beyond_m: float = 0.1
    """[m] Points displaced by more than this by the errors count as doubled, if more than one unit sees their actor. It
    is the accuracy of a LUX by its data sheet: smaller displacements are within its errors."""

    def __post_init__(self) -> None:
        for name in ("yaw_sigma_deg", "pitch_sigma_deg", "roll_sigma_deg"):
            if not 0.0 <= getattr(self, name) <= 10.0:
                raise ValueError(
                    f"{name} = {getattr(self, name)}: must be from 0 to 10; enter larger errors in the rig file"
                )
        for name in ("xy_sigma_m", "z_sigma_m"):
            if not 0.0 <= getattr(self, name) <= 0.2:
                raise ValueError(
                    f"{name} = {getattr(self, name)}: must be from 0 to 0.2; enter larger errors in the rig file"
                )
        if not 0.0 <= self.sync_sigma_ms <= 20.0:
            raise ValueError(
                f"sync_sigma_ms = {self.sync_sigma_ms}: must be from 0 to 20; or set phase_ms in the rig file"
            )
        if not self.doubled_beyond_m > 0.0:
            raise ValueError(f"doubled_beyond_m = {self.doubled_beyond_m}: must be positive")


def true_mounts(config: CalibrationError, units: UnitTable, draws: Draws) -> tuple[Floats, Floats]:
    """Draw the true mounting poses of the units, constant over a run.

    Returns
    -------
    (U, 3) origin_ego [m], (U, 3, 3) R_ego_unit: the nominal rotation after one by yaw about the unit's z, pitch about
    its new y and roll about its new x.
    """
    if not config.enabled:
        return units.origin_ego, units.R_ego_unit
    unit, coordinate = np.divmod(np.arange(6 * len(units)), 6)
    normal = draws.normal_of(_RUN, unit, coordinate, Purpose.MOUNT).reshape(-1, 6)
    shift = normal[:, :3] * (config.xy_sigma_m, config.xy_sigma_m, config.z_sigma_m)
    turn_deg = normal[:, 3:] * (config.yaw_sigma_deg, config.pitch_sigma_deg, config.roll_sigma_deg)
    R_nominal_true = scipy.spatial.transform.Rotation.from_euler("ZYX", turn_deg, degrees=True).as_matrix()
    return units.origin_ego + shift, elementwise.product(units.R_ego_unit, R_nominal_true)


def sync_jitter(config: CalibrationError, units: int, frame: int, draws: Draws) -> Floats:
    """Return the (U,) delay of each unit's true firing times relative to the reported ones in a frame [s]."""
    if not config.enabled:
        return np.zeros(units)
    return config.sync_sigma_ms / 1000.0 * draws.normal_of(frame, np.arange(units), 0, Purpose.SYNC)


def doubled_points(config: CalibrationError, displacement: Floats, unit: Bytes, actor: Ints, actors: int) -> Bools:
    """Return the (N,) mask of points that double a contour.

    Parameters
    ----------
    displacement
        (N,) displacement of each point by the calibration errors [m].
    unit, actor
        (N,) unit of each point, and row of the actor that it is on, negative without one.
    actors
        Number of actors.
    """
    on_actor = actor >= 0
    seen_by = np.zeros((actors, 256), dtype=np.bool_)
    seen_by[actor[on_actor], unit[on_actor]] = True
    twice = on_actor & (displacement > config.doubled_beyond_m)
    twice[twice] = seen_by[actor[twice]].sum(axis=1) >= 2
    return twice
