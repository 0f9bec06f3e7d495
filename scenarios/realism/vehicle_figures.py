"""Figures of labelled vehicles, in the columns of a table of real vehicles."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.realism import heading_error
from luxloop.scenarios.realism.face_depth import least_depth, visible_faces
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.scenarios.realism.scan_lines import SIGMA_PER_MAD, layers_apart, lines_over

ABOUT_FACES_M = 0.30
"""[m] Largest depth of the points of the spread about the faces."""
INSIDE_CM = (10, 20, 40)
OUTSIDE_M = 0.10
HIGH_M = 0.90
DENSITY_POINTS_MIN = 3
"""Least number of points of a line whose density is measured."""


def keys(vehicles: Sequence[LabelledVehicle]) -> pd.DataFrame:
    """Return data set, actor and frame of each vehicle, and the view by which it is matched."""
    columns = ("data_set", "actor_id", "frame", "kind", "range_m", "aspect_deg", "front_seen")
    return pd.DataFrame({name: [getattr(vehicle, name) for vehicle in vehicles] for name in columns})


def measure(vehicles: Sequence[LabelledVehicle]) -> pd.DataFrame:
    """Return the figures of each of at least one vehicle; NaN for a figure that its points do not give."""
    figures = pd.DataFrame([_shape(vehicle) for vehicle in vehicles])
    error_deg, on_lines = heading_error.measure(vehicles)
    figures["share_on_lines"] = on_lines
    for method, column in zip(heading_error.REPORTED, error_deg.T, strict=True):
        figures[f"{method}_error_deg"] = column
    return figures


def _shape(vehicle: LabelledVehicle) -> dict[str, float]:
    """Return all figures of one vehicle but those of the tracker's fits."""
    height = vehicle.points_ego[:, 2]
    faces = visible_faces(vehicle)
    depth = least_depth(faces)
    figures = {
        "points": float(len(height)),
        "layers": float(len(np.unique(vehicle.line))),
        "z_median_m": float(np.median(height)),
        "share_above_0.9m": float((height > HIGH_M).mean()),
        **{f"share_{cm}cm_inside": float((depth > cm / 100).mean()) for cm in INSIDE_CM},
        "share_10cm_outside": float((depth < -OUTSIDE_M).mean()),
        "std_about_faces_m": _robust_std(depth[np.abs(depth) < ABOUT_FACES_M]),
        "points_per_m_layer": density(vehicle.points_box, vehicle.line),
    }
    for end, name in ((True, "end"), (False, "flank")):
        seen = [face for face in faces if face.end == end]
        lines = [line for face in seen for line in lines_over(face, vehicle.line, height)]
        figures[f"line_noise_{name}_m"] = median([line.noise_m for line in lines])
        figures[f"bow_{name}_m"] = median([line.bow_m for line in lines])
        figures[f"layers_apart_{name}_m"] = median([layers_apart(face, vehicle.line) for face in seen])
    return figures


def density(points: Floats, line: Ints) -> float:
    """Return the points per metre of scan line [1/m]: the median over the lines, NaN without a line of enough points.

    Parameters
    ----------
    points
        (N, 2) points in the frame of the box [m]; a line's length is its larger extent along the axes.
    line
        (N,) scan line of each point.
    """
    lines = [points[line == number] for number in np.unique(line)]
    lengths = [(len(own), np.ptp(own, axis=0).max()) for own in lines if len(own) >= DENSITY_POINTS_MIN]
    return median([count / length for count, length in lengths if length > 0.0])


def _robust_std(values: Floats) -> float:
    return float(SIGMA_PER_MAD * np.median(np.abs(values - np.median(values)))) if len(values) else float("nan")


def median(values: Sequence[float]) -> float:
    """Return the median of the finite values; NaN without any."""
    finite = [value for value in values if np.isfinite(value)]
    return float(np.median(finite)) if finite else float("nan")
