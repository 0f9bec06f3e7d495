"""Labels of the cars in public Ouster recordings, as `tests/data/ouster_labels` has them."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

LABELS = Path(__file__).parents[2] / "tests" / "data" / "ouster_labels"
CLASSES = ("small car", "sedan", "SUV", "van", "pickup", "truck")


@dataclass(frozen=True, slots=True)
class View:
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
    reflectivity: float | None
    """Median of the unit's calibrated reflectivity over the lower body, 0 to 1; None for a unit without."""

    @property
    def range_m(self) -> float:
        """Distance of the centre from the sensor over the ground [m]."""
        return float(np.hypot(self.x_m, self.y_m))

    def in_box(self, points_level: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
        """Return points (N, 3) in the frame of the vehicle: ahead, left and above its ground [m]."""
        heading = np.deg2rad(self.heading_deg)
        offset = points_level - [self.x_m, self.y_m, self.z_ground_m]
        ahead = offset[:, 0] * np.cos(heading) + offset[:, 1] * np.sin(heading)
        left = offset[:, 1] * np.cos(heading) - offset[:, 0] * np.sin(heading)
        return np.column_stack([ahead, left, offset[:, 2]])


def load_views(folder: Path = LABELS) -> list[View]:
    """Read the poses of the sensors."""
    return [
        View(row["recording"], int(row["frame"]), *(float(row[key]) for key in ("height_m", "pitch_deg", "roll_deg")))
        for row in _rows(folder / "frames.csv")
    ]


def load_cars(folder: Path = LABELS) -> list[Car]:
    """Read the labelled vehicles."""
    return [_car(row) for row in _rows(folder / "cars.csv")]


def _car(row: dict[str, str]) -> Car:
    metric = ("x_m", "y_m", "z_ground_m", "heading_deg", "length_m", "width_m", "height_m")
    return Car(
        id=row["id"],
        recording=row["recording"],
        frame=int(row["frame"]),
        category=row["class"],
        **{key: float(row[key]) for key in metric},
        end_seen=row["end_seen"].strip("-"),
        side_seen=row["side_seen"].strip("-"),
        **{key: row[key] == "1" for key in ("unobstructed", "length_seen", "width_seen")},
        heading_sigma_deg=float(row["heading_sigma_deg"]),
        position_sigma_m=float(row["position_sigma_m"]),
        reflectivity=float(row["reflectivity"]) if row["reflectivity"] else None,
    )


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
