"""Figures of labelled vehicles, in the columns of a table of real vehicles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from luxloop.arrays import Bools, Floats, Ints
from luxloop.scenarios.realism import labelled_fits
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle

NEAR_M = 0.60
"""[m] Depth of the points that place a face."""
CLEAR_M = 0.25
"""[m] Their least distance from the ends of the face, which excludes points of the next face."""
NEAR_POINTS_MIN = 5
"""Least number of these points; with fewer, the face stays at the label."""
SKIN_PERCENTILE = 10.0
"""Percentile of their depths that becomes depth 0, so that errors of the label's position do not count."""

NORMALS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
"""Outward normals of front, rear, left and right in the frame of the box."""


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """A visible face with all points of its vehicle."""

    end: bool
    """True for a front or rear, False for a flank."""
    along: Floats
    """(N,) coordinate of each point along the face, from its middle [m]."""
    depth: Floats
    """(N,) distance of each point behind the face, positive inside [m]."""


def visible_faces(vehicle: LabelledVehicle) -> list[Face]:
    """Return the faces in front of whose planes a LIDAR with points on the vehicle is, moved onto the points."""
    half = 0.5 * vehicle.box[3:]
    points, lidars = vehicle.points_box, vehicle.lidars_box
    return [_placed(points, normal, half) for normal in NORMALS if (lidars @ normal > np.abs(normal) @ half).any()]


def least_depth(faces: list[Face]) -> Floats:
    """Return the depth (N,) of each point behind the visible face that it is nearest to the outside of [m]."""
    depth: Floats = np.min([face.depth for face in faces], axis=0)
    return depth


def _placed(points: Floats, normal: Floats, half: Floats) -> Face:
    """Return a face moved to the 10th percentile of the depths of the points near it; unmoved if these are too few."""
    axis = np.abs(normal)
    depth, along = axis @ half - points @ normal, points @ axis[::-1]
    near = depth[(depth < NEAR_M) & (np.abs(along) < axis[::-1] @ half - CLEAR_M)]
    skin = np.percentile(near, SKIN_PERCENTILE) if len(near) >= NEAR_POINTS_MIN else 0.0
    return Face(end=bool(axis[0]), along=along, depth=depth - skin)


POINTS_MIN = 7
"""Least number of points of a parabola."""
OUTLIER_SIGMAS = 3.0
EXACT_M = 1e-6
"""[m] Residuals below are rounding errors, not outliers."""
MIDDLE_POINTS_MIN = 3
"""Least number of points of the median depth of a line."""
SIGMA_PER_MAD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


@dataclass(frozen=True, slots=True)
class Window:
    """Part of a face that is measured, for ends or flanks [m]."""

    half_m: float
    """Half-width of the parabola."""
    span_min_m: float
    """Least extent of its points."""
    middle_m: float
    """Half-width of the middle, where the lines' depths are compared."""
    depth_max_m: float
    """Largest depth of the points of a parabola: hoods lie behind an end, only seats and panes behind a flank."""
    middle_depth_max_m: float
    """Largest depth of the points of the middle."""


END, FLANK = Window(0.75, 1.0, 0.45, 1.2, 1.2), Window(1.6, 2.0, 1.2, 0.3, 0.6)


@dataclass(frozen=True, slots=True)
class ScanLine:
    """Parabola through one scan line over a face."""

    bow_m: float
    """Sagitta over the window's half-width, positive if the middle stands out."""
    noise_m: float
    """Standard deviation of the points about the parabola."""
    height_m: float
    """Median height of the points above the ground."""


def lines_over(face: Face, line: Ints, height: Floats) -> list[ScanLine]:
    """Return the parabolas of the scan lines over a face that have enough points over enough of its width.

    Parameters
    ----------
    face
        Face with N points.
    line
        (N,) scan line of each point.
    height
        (N,) height of each point above the ground [m].
    """
    window = window_of(face)
    near = (np.abs(face.along) <= window.half_m) & (face.depth <= window.depth_max_m)
    found = []
    for number in np.unique(line[near]):
        own = near & (line == number)
        if own.sum() >= POINTS_MIN and np.ptp(face.along[own]) >= window.span_min_m:
            bow, noise = parabola(face.along[own], face.depth[own], window.half_m)
            found.append(ScanLine(bow, noise, float(np.median(height[own]))))
    return found


def parabola(along: Floats, depth: Floats, half_m: float) -> tuple[float, float]:
    """Fit a parabola to points (N,) of a scan line; return its sagitta over `half_m` and the noise about it [m].

    Points beyond three robust standard deviations of a first fit are left out of the second one.
    """
    residual = depth - np.polyval(np.polyfit(along, depth, 2), along)
    sigma = SIGMA_PER_MAD * np.median(np.abs(residual))
    kept: Bools = np.abs(residual) <= max(OUTLIER_SIGMAS * sigma, EXACT_M)
    if kept.sum() < POINTS_MIN:
        kept[:] = True
    curve = np.polyfit(along[kept], depth[kept], 2)
    residual = (depth - np.polyval(curve, along))[kept]
    return float(curve[0] * half_m**2), float(np.sqrt(np.mean(residual**2)))


def layers_apart(face: Face, line: Ints) -> float:
    """Return the spread of the median depths of the scan lines (N,) in the middle of a face [m]; NaN for one line."""
    window = window_of(face)
    middle = (np.abs(face.along) <= window.middle_m) & (face.depth <= window.middle_depth_max_m)
    numbers, counts = np.unique(line[middle], return_counts=True)
    lines = numbers[counts >= MIDDLE_POINTS_MIN]
    if len(lines) < 2:
        return float("nan")
    return float(np.ptp([np.median(face.depth[middle & (line == number)]) for number in lines]))


def window_of(face: Face) -> Window:
    """Return the window of a face."""
    return END if face.end else FLANK


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


REPORTED = ("area", "closeness", "variance", "tlinkage", "best")
"""Methods with a figure; `best` is the selected rectangle."""


def measure(vehicles: Sequence[LabelledVehicle]) -> pd.DataFrame:
    """Return the figures of each of at least one vehicle; NaN for a figure that its points do not give."""
    figures = pd.DataFrame([_shape(vehicle) for vehicle in vehicles])
    fits = labelled_fits.fit(vehicles)
    figures["share_on_lines"] = fits.on_lines
    for method in REPORTED:
        figures[f"{method}_error_deg"] = np.abs(fits.error_deg[method])
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
