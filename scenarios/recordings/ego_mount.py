"""Mounts of a recording's LIDARs: from the sensor's frame to the ego frame."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError
from luxloop.sensor_model.rig.rig import Rig, load_rig

LEAST_NUMBERS = 3


@dataclass(frozen=True, slots=True, eq=False)
class EgoMount:
    """Pose of a LIDAR in the ego frame (origin on the ground, x forward, y left, z up)."""

    origin_ego: Floats
    """(3,) [m]."""
    R_ego_unit: Floats
    """(3, 3) rotation: ego = R unit."""

    @classmethod
    def of(cls, origin: Floats, yaw_deg: float, pitch_deg: float, roll_deg: float) -> "EgoMount":
        """Rotate by yaw about z, then pitch about y (positive looks down), then roll about x, as in rig files."""
        rotation = Rotation.from_euler("ZYX", [yaw_deg, pitch_deg, roll_deg], degrees=True)
        return cls(np.asarray(origin, dtype=np.float64), rotation.as_matrix())

    @classmethod
    def parse(cls, text: str) -> "EgoMount":
        """Read `X,Y,Z[,YAW[,PITCH[,ROLL]]]` in metres and degrees.

        Raises
        ------
        InputError
            The text is not three to six finite numbers.
        """
        try:
            numbers = [float(part) for part in text.split(",")]
        except ValueError:
            numbers = []
        if not LEAST_NUMBERS <= len(numbers) <= 6 or not np.isfinite(numbers).all():
            raise InputError(f"--mount {text}: should be X,Y,Z or X,Y,Z,YAW,PITCH,ROLL in metres and degrees")
        x, y, z, yaw, pitch, roll = [*numbers, 0.0, 0.0, 0.0][:6]
        return cls.of(np.array([x, y, z]), yaw, pitch, roll)

    def to_ego(self, points: Floats) -> Floats:
        """Return points (N, 3) of the sensor's frame in the ego frame [m]."""
        rotated: Floats = points @ self.R_ego_unit.T
        return rotated + self.origin_ego


def of_rig(name_or_path: str) -> tuple[Rig, list[EgoMount]]:
    """Read a rig file and return the mounts of its units.

    Raises
    ------
    RigError
        The file is missing or invalid.
    """
    rig = load_rig(name_or_path, Path.cwd())
    return rig, [
        EgoMount.of(
            np.array([rig.rear_axle_x_m + mount.x_m, mount.y_m, mount.z_m]),
            mount.yaw_deg, mount.pitch_deg, mount.roll_deg,
        )
        for mount in rig.mounts
    ]  # fmt: skip
