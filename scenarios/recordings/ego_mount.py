"""Mounts of LIDARs on the ego, from a rig file, from options, or levelled by the ground in the scan."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from luxloop.arrays import Floats
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


REACH_M = 20.0
"""[m] Farther points are not used: beyond, streets bend away from their plane."""
CELL_M = 2.0
"""[m] Side of the cells whose low points are ground. A cell is free of vehicles somewhere in most streets."""
LOW_PERCENT = 10.0
"""The ground of a cell is this percentile of its heights: lower points are echoes from mirrors and holes."""
LEAST_POINTS, LEAST_CELLS = 10, 10
"""Points of a usable cell, and cells of a usable fit."""
PASSES = 2
"""Fits: the first one turns the points upright, as the low points of a cell must be."""
STEPS = 20
"""Steps of the reweighting, which converges in fewer."""
SPREAD_M = 0.05
"""[m] Scale of the Cauchy weights: the height of kerbs is twice this, cars are far outside."""


def levelled(points: Floats, mount: EgoMount) -> EgoMount:
    """Return a mount with its height, pitch and roll over the ground of a sweep.

    The ground is the plane z = a + b x + c y through the low points of square cells, by iteratively reweighted least
    squares with Cauchy weights (Holland and Welsch 1977), and then through all points near that plane.

    Parameters
    ----------
    points
        (N, 3) in the sensor's frame [m].
    mount
        The mount; its position in the plane and its yaw are kept, and its rotation is the start of the fit.

    Raises
    ------
    InputError
        There are too few points on the ground.
    """
    rotation = mount.R_ego_unit
    for _ in range(PASSES):
        turned = _near(points @ rotation.T)
        low = _low_points(turned)
        if len(low) < LEAST_CELLS:
            raise InputError("--level: the first sweep has too few points on the ground; give --mount with its height")
        plane = _through_ground(turned, _plane(low))
        normal = np.array([-plane[1], -plane[2], 1.0]) / np.sqrt(1.0 + plane[1] ** 2 + plane[2] ** 2)
        upright = Rotation.align_vectors([[0.0, 0.0, 1.0]], [normal])[0].as_matrix()
        rotation, height = upright @ rotation, -plane[0] * normal[2]
    return EgoMount(np.array([*mount.origin_ego[:2], height]), rotation)


def _near(points: Floats) -> Floats:
    return points[np.hypot(points[:, 0], points[:, 1]) < REACH_M]


def _low_points(points: Floats) -> Floats:
    """(C, 3) centre of each used cell, and the height of its low points."""
    cell = np.floor(points[:, :2] / CELL_M).astype(np.int64)
    _, at, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(at, kind="stable")
    parts = np.split(order, np.cumsum(count)[:-1])
    found = [
        [*points[part, :2].mean(axis=0), np.percentile(points[part, 2], LOW_PERCENT)]
        for part in parts
        if len(part) >= LEAST_POINTS
    ]
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def _plane(low: Floats) -> Floats:
    """(3,) a, b, c of z = a + b x + c y."""
    terms = np.column_stack([np.ones(len(low)), low[:, :2]])
    plane = np.array([np.percentile(low[:, 2], LOW_PERCENT), 0.0, 0.0])
    for scale in np.geomspace(10.0 * SPREAD_M, SPREAD_M, STEPS):
        weight = 1.0 / (1.0 + ((low[:, 2] - terms @ plane) / scale) ** 2)
        root = np.sqrt(weight)
        plane = np.linalg.lstsq(root[:, None] * terms, root * low[:, 2], rcond=None)[0]
    return plane


def _through_ground(points: Floats, plane: Floats) -> Floats:
    """(3,) a, b, c of the plane through the points near a first plane, by least squares."""
    terms = np.column_stack([np.ones(len(points)), points[:, :2]])
    ground = np.abs(points[:, 2] - terms @ plane) < 2.0 * SPREAD_M
    found: Floats = np.linalg.lstsq(terms[ground], points[ground, 2], rcond=None)[0]
    return found if ground.sum() > LEAST_POINTS else plane
