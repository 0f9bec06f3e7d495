"""Fits of the tracker to labelled vehicles, each as one segment."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.grading.plane_geometry import QUARTER, wrap
from luxloop.scenarios.realism.labelled_vehicle import LabelledVehicle
from luxloop.tracker.detection import rectangles, segmentation, selection, tlinkage
from luxloop.tracker.detection.detector import DetectorConfig
from luxloop.tracker.records import METHODS, Segments

CRITERIA = tuple(method for method in METHODS if method != "refined")
"""Candidates of the selection."""
COMPARED = (*CRITERIA, "alignment")
"""Methods that `best` is compared with; `alignment` is the best aligned candidate, turned to the highest alignment."""


@dataclass(frozen=True, slots=True, eq=False)
class LabelledFits:
    """Fits of V vehicles."""

    error_deg: dict[str, Floats]
    """(V,) heading errors of each of `COMPARED` and of `best`, modulo 90 degrees, -45 to 45."""
    std_deg: Floats
    """(V,) stated standard deviation of `best`; NaN if the selection states none."""
    on_lines: Floats
    """(V,) share of the points that T-linkage leaves on lines."""


def fit(vehicles: Sequence[LabelledVehicle], config: DetectorConfig | None = None) -> LabelledFits:
    """Fit rectangles to the points of at least one vehicle, by default with the tracker's default settings."""
    config = config or DetectorConfig()
    sizes = [len(vehicle.points_ego) for vehicle in vehicles]
    segments = Segments(np.repeat(np.arange(len(sizes)), sizes), len(sizes))
    cloud, lines = (np.concatenate([getattr(vehicle, name) for vehicle in vehicles]) for name in ("points_ego", "line"))
    points = segmentation.sort_by_segment(cloud, segments, scan_line=lines)
    linkage = tlinkage.link(points, config.linkage, config.lidar)
    headings = rectangles.headings(points, linkage, config.rectangles)
    each = np.arange(len(vehicles))

    def selected(chosen: selection.SelectionConfig) -> tuple[Floats, Floats]:
        found = selection.select(points, linkage, headings, chosen, config.lidar.range_std_m)
        variance = np.full(len(each), np.nan) if found.heading_variance is None else found.heading_variance
        return found.heading[each, found.best], np.degrees(np.sqrt(variance))

    best, std_deg = selected(config.selection)
    aligned, _ = selected(replace(config.selection, variant="alignment"))
    found = dict(zip((*COMPARED, "best"), (*headings.T, aligned, best), strict=True))
    yaw = np.array([vehicle.box[2] for vehicle in vehicles])
    return LabelledFits(
        error_deg={name: np.degrees(wrap(heading - yaw, QUARTER)) for name, heading in found.items()},
        std_deg=std_deg,
        on_lines=np.bincount(segments.label, linkage.line >= 0, segments.count) / np.bincount(segments.label),
    )
