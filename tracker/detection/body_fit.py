"""Body fit: heading and covariance of the vehicle of each segment, by faces that are bowed like those of real cars."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.tracker.arrays import Floats, Ints
from luxloop.tracker.bounds import require_within
from luxloop.tracker.detection.body_search import search_bodies
from luxloop.tracker.detection.kernels.bowed_faces import BodyShape
from luxloop.tracker.detection.segmentation import by_segment, positions
from luxloop.tracker.records import Segments
from luxloop.tracker.scan import Scan


@dataclass(frozen=True, slots=True)
class BodyFitConfig:
    """Shape of vehicles, and scatter of points about their faces.

    A bow is the curvature of a parabola in plan: 0.22 per metre is 12 cm over 0.75 m to either side of the middle.
    """

    range_std_m: float = 0.027
    """Range noise along the beam [m], as `linkage.range_std_m`."""
    flatness_m: float = 0.02
    """Standard deviation of points across a face without range noise [m]: single scan lines scatter by 2.0 cm on the
    flanks of real cars."""
    line_std_m: float = 0.1
    """Standard deviation of the depth of a scan line on a face [m]: bumper, hood and glass are decimetres apart (median
    of real cars between the layers: 0.2 to 0.3 m from lowest to highest)."""
    inside_m: float = 1.0
    """Mean depth of points inside the body [m]: windscreens lie 0.9 to 1.2 m behind the bumper."""
    inside_share: float = 0.03
    """Share of points inside the body, at the depth of a face."""
    cost_max: float = 6.0
    """Cost of an outlier: that of a point 3.5 standard deviations off."""
    flank_curvature_per_m: float = 0.02
    """Curvature of flanks [1/m]: 0.027 for real cars (7 cm over 1.6 m to either side), 0 for trucks."""
    flank_curvature_std_per_m: float = 0.02
    """Its standard deviation [1/m]."""
    end_curvature_per_m: float = 0.22
    """Curvature of fronts and rears [1/m]: 0.17 to 0.42 for real cars by height, 0 for trucks."""
    end_curvature_std_per_m: float = 0.5
    """Its standard deviation [1/m]: arcs of hoods and greenhouses are bowed twice as much."""
    flank_length_m: float = 4.4
    """Length of a flank that is visible in part [m]: a medium-sized car."""
    end_length_m: float = 1.8
    """Length of an end that is visible in part [m]: the width of cars."""
    flank_whole_min_m: float = 3.0
    """Minimum visible length of a whole flank [m]: the shortest cars measure 2.7 to 3.6."""
    end_whole_min_m: float = 1.4
    """Minimum visible length of a whole end [m]: car width less two rounded corners."""
    flank_middle_std_m: float = 0.3
    """Standard deviation of the middle of a whole flank [m]: wheel arches and corners hide its ends."""
    end_middle_std_m: float = 0.08
    """The same of a whole end [m]: its shape is symmetric."""
    part_middle_std_m: float = 0.8
    """Standard deviation of the middle of a face that is visible in part [m]: half the width of a car."""
    width_max_m: float = 2.4
    """Maximum visible length of an end [m]: trucks measure 2.55 between the rounded edges."""
    alignment_weight: float = 4.0
    """Weight of the density of points along the faces, which needs no model of their shape, beside this model."""
    temperature: float = 5.0
    """Difference of cost at which another result is e times less likely. Points are correlated, so it is above 1."""
    asymmetry_std_rad: float = 0.005
    """Standard deviation of the heading for reasons outside the model [rad]: flanks converge by 2 cm over a car."""

    def __post_init__(self) -> None:
        require_within(self, 1e-6, 1e3, "range_std_m", "flatness_m", "line_std_m", "inside_m", "cost_max")
        require_within(self, 1e-6, 1.0 - 1e-6, "inside_share")
        require_within(self, 0.0, 10.0, "flank_curvature_per_m", "end_curvature_per_m", "asymmetry_std_rad")
        require_within(self, 1e-6, 10.0, "flank_curvature_std_per_m", "end_curvature_std_per_m")
        require_within(self, 1e-3, 1e3, "flank_length_m", "end_length_m", "flank_whole_min_m", "end_whole_min_m")
        require_within(self, 1e-6, 1e3, "flank_middle_std_m", "end_middle_std_m", "part_middle_std_m", "width_max_m")
        require_within(self, 0.0, 1e3, "alignment_weight")
        require_within(self, 1e-3, 1e6, "temperature")


class BodyFit(NamedTuple):
    """Bodies of S segments."""

    heading: Floats
    """(S,) modulo a quarter turn, ego frame [rad]."""
    cost: Floats
    """(S,) cost per point."""
    covariance: Floats
    """(S, 3, 3) of x, y [m] and heading [rad], ego frame, of a body that turns about the mean of its points."""


def scan_lines(scan: Scan) -> Ints:
    """(N,) number of each point's scan line, one per unit and layer."""
    layers = int(scan.layer.max(initial=0)) + 1
    return np.asarray(scan.unit.astype(np.int64) * layers + scan.layer)


def fit(
    points_ego: npt.NDArray[np.floating],
    scan_line: Ints,
    segments: Segments,
    heading: Floats,
    reach_m: float,
    edge_m: float,
    config: BodyFitConfig,
) -> BodyFit:
    """Fit the body of each segment, from the best of its candidate headings (S, M).

    The cost is the negative log-likelihood of the points under `bowed_faces`, plus the weighted misalignment, with
    kernel radius `reach_m` and `edge_m` at grazing incidence [m]. The order of the points has no effect.

    Parameters
    ----------
    points_ego
        (N, 2 or more columns) [m].
    scan_line
        (N,) scan line of each point, 0 and up.
    """
    order, offset = by_segment(segments)
    found = search_bodies(
        positions(points_ego, order),
        np.asarray(scan_line[order], dtype=np.int64),
        segments.label[order],
        offset,
        np.ascontiguousarray(heading),
        _shape(config),
        np.array([reach_m, edge_m, config.alignment_weight]),
        config.temperature,
    )
    fitted = BodyFit(*found)
    fitted.covariance[:, 2, 2] += config.asymmetry_std_rad**2
    return fitted


def _shape(config: BodyFitConfig) -> BodyShape:
    """Return the settings of flanks and ends for kernels."""
    return BodyShape(
        range_std=config.range_std_m,
        flatness=config.flatness_m,
        line_std=config.line_std_m,
        inside=config.inside_m,
        inside_share=config.inside_share,
        cost_max=config.cost_max,
        curvature=(
            (config.flank_curvature_per_m, config.flank_curvature_std_per_m),
            (config.end_curvature_per_m, config.end_curvature_std_per_m),
        ),
        length=(config.flank_length_m, config.end_length_m),
        whole_min=(config.flank_whole_min_m, config.end_whole_min_m),
        middle_std=(
            (config.part_middle_std_m, config.flank_middle_std_m),
            (config.part_middle_std_m, config.end_middle_std_m),
        ),
        width_max=config.width_max_m,
    )
