"""Checks of a tracker's trace: its labels refer to the points of the scan, its boxes to its segments."""

from typing import Any

import numpy as np

from luxloop.scenarios.run.output_checks import Fault, Faults, check_array, shape_text
from luxloop.tracker.records import METHODS, NOT_USED, StepTrace
from luxloop.tracker.scan import Scan

CHECK = "trace matches its scan"

SEGMENT_ARRAYS: dict[str, tuple[tuple[int | str, ...], str]] = {
    "linkage.heading": ((), "f"),
    "candidates.heading": (("M",), "f"),
    "candidates.center_ego": (("M", 2), "f"),
    "candidates.size": (("M", 2), "f"),
    "candidates.cost": (("M",), "f"),
    "candidates.best": ((), "iu"),
}
"""Shape without the first axis, S segments, and kinds of dtype; M is the number of methods."""
BOX_ARRAYS: dict[str, tuple[tuple[int | str, ...], str]] = {
    "boxes.segment": ((), "iu"),
    "boxes.center_ego": ((2,), "f"),
    "boxes.heading": ((), "f"),
    "boxes.size": ((2,), "f"),
    "boxes.corner_ego": ((2,), "f"),
    "boxes.corner_sign": ((2,), "iu"),
    "boxes.covariance": ((3, 3), "f"),
    "boxes.support": ((), "iu"),
    "boxes.time_offset": ((), "f"),
    "boxes.cut": ((2, 2), "b"),
    "boxes.flat": ((), "b"),
    "boxes.viewpoint_ego": ((2,), "f"),
    "track_id": ((), "iu"),
}
"""The same for B boxes."""


def check_trace(trace: StepTrace, scan: Scan) -> Faults:
    """Check that labels refer to the points of this scan, and boxes to its segments."""
    label, count = trace.segments.label, trace.segments.count
    for name, values in (("segments.label", label), ("linkage.line", trace.linkage.line)):
        if np.shape(values) != (len(scan),):
            what = f"{name} has shape {shape_text(np.shape(values))}, but the scan has {len(scan)} points"
            yield Fault(CHECK, what)
            return
    if len(label) and not (label.min() >= NOT_USED and label.max() < count):
        yield Fault(CHECK, f"segments.label is {label.min()} to {label.max()} for {count} segments")
    segment = trace.boxes.segment
    if len(segment) and not (segment.min() >= 0 and segment.max() < count):
        yield Fault(CHECK, f"boxes.segment is {segment.min()} to {segment.max()} for {count} segments")
    if len(trace.track_id) != len(segment):
        yield Fault(CHECK, f"track_id has {len(trace.track_id)} entries for {len(segment)} boxes")


def check_trace_shapes(trace: StepTrace) -> Faults:
    """Check the arrays of segments and boxes; `check_trace` needs this to pass."""
    count = trace.segments.count
    if not isinstance(count, int | np.integer) or isinstance(count, bool) or count < 0:
        yield Fault("shapes and types", f"segments.count is {count!r}, not a number of segments")
        return
    for name, value in (("segments.label", trace.segments.label), ("linkage.line", trace.linkage.line)):
        yield from check_array(name, value, np.shape(value)[:1] or ("N",), "iu")
    methods = (*np.shape(trace.candidates.heading), 0, 0)[1]
    if methods < len(METHODS):
        yield Fault("shapes and types", f"candidates has {methods} methods, not {', '.join(METHODS)}")
    boxes = (*np.shape(trace.boxes.segment), 0)[0]
    for rows, arrays in ((int(count), SEGMENT_ARRAYS), (boxes, BOX_ARRAYS)):
        for name, (shape, kinds) in arrays.items():
            wanted = (rows, *(methods if axis == "M" else axis for axis in shape))
            yield from check_array(name, _field(trace, name), wanted, kinds)


def _field(trace: StepTrace, name: str) -> Any:
    """Return the value of a field by its path, `boxes.size` or `track_id`."""
    record, _, field = name.rpartition(".")
    return getattr(getattr(trace, record) if record else trace, field)
