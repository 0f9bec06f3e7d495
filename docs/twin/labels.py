"""Labels of the cars in public Ouster recordings, as `tests/data/ouster_labels` has them."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import turned

LABELS = Path(__file__).parents[2] / "tests" / "data" / "ouster_labels"
CLASSES = ("small car", "sedan", "SUV", "van", "pickup", "truck")


class View(NamedTuple):
    """Pose of the sensor over the ground plane of one frame. The level frame is the sensor's, levelled to that plane.

    Its origin is on the plane below the sensor, z is up, and x is ahead.
    """

    recording: str
    frame: int
    height_m: float
    pitch_deg: float
    roll_deg: float


@dataclass(frozen=True, slots=True)
class Car:
    """Labelled vehicle, in the level frame of its recording and frame."""

    id: str
    recording: str
    frame: int
    category: str
    """Member of `CLASSES`."""
    x_m: float
    """Centre of the box."""
    y_m: float
    z_ground_m: float
    """Height of the ground below the vehicle over the plane."""
    heading_deg: float
    """Direction of the nose, counter-clockwise from x."""
    length_m: float
    width_m: float
    """Without mirrors."""
    height_m: float
    end_seen: str
    """`front`, `rear`, or empty."""
    side_seen: str
    """`left`, `right`, or empty."""
    unobstructed: bool
    """True if no other object hides a visible face."""
    length_seen: bool
    """True if both ends of a side are in view; otherwise the length is typical of the class."""
    width_seen: bool
    """True if an end is in view over its whole width; otherwise the width is typical of the class."""
    heading_sigma_deg: float
    position_sigma_m: float
    reflectivity: float
    """Median of the unit's calibrated reflectivity over the lower body, 0 to 1; NaN for a unit without."""

    @property
    def range_m(self) -> float:
        """Distance of the centre from the sensor over the ground [m]."""
        return float(np.hypot(self.x_m, self.y_m))

    @property
    def box(self) -> Floats:
        """(5,) x, y [m], yaw [rad], length and width [m]."""
        return np.array([self.x_m, self.y_m, np.radians(self.heading_deg), self.length_m, self.width_m])

    def in_box(self, points_level: Floats) -> Floats:
        """Return points (N, 3) in the frame of the vehicle: ahead, left and above its ground [m]."""
        offset = points_level - [self.x_m, self.y_m, self.z_ground_m]
        return np.column_stack([turned(offset[:, :2], -np.radians(self.heading_deg)), offset[:, 2]])


def load_views() -> list[View]:
    """Read the poses of the sensors."""
    return [View(**row) for row in pd.read_csv(LABELS / "frames.csv").to_dict("records")]


def load_cars() -> list[Car]:
    """Read the labelled vehicles."""
    table = pd.read_csv(LABELS / "cars.csv").rename(columns={"class": "category"})
    table = table.astype(dict.fromkeys(("unobstructed", "length_seen", "width_seen"), bool))
    table = table.replace({"end_seen": "-", "side_seen": "-"}, "")
    return [Car(**row) for row in table.to_dict("records")]
