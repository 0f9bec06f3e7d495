"""Checks of a tracker's output for one scan."""

from collections.abc import Callable
from typing import Any

import numpy as np

from scenarios.arrays import Bools, Floats
from scenarios.check_tracker.checks import Fault, Faults
from tracker.records import MODEL_NAMES, NOT_USED, PREDICTION_S, Status, StepTrace, Tracks
from tracker.scan import Scan

M = "M"
"""Number of models of the tracker."""

SHAPES: dict[str, tuple[tuple[int | str, ...], str]] = {
    "id": ((), "iu"),
    "status": ((), "iu"),
    "mean": ((8,), "f"),
    "covariance": ((8, 8), "f"),
    "model_probability": ((M,), "f"),
    "model": ((), "iu"),
    "model_position_odom": ((M, 2), "f"),
    "corner_sign": ((2,), "iu"),
    "size": ((2,), "f"),
    "model_covariance_odom": ((M, 2, 2), "f"),
    "model_nis": ((M,), "f"),
    "prediction_odom": (("M + 1", len(PREDICTION_S), 2), "f"),
}
"""Shape of each field of `Tracks` without its first axis, and the allowed kinds of dtype."""
OPTIONAL = ("model_covariance_odom", "model_nis", "prediction_odom")
TOLERANCE = 1e-6
"""Tolerance of a sum of probabilities, and of symmetry and eigenvalues of a covariance relative to its size."""


def check_shapes(tracks: Tracks) -> Faults:
    """Check that every field is an array of its shape and dtype; other checks need this one to pass."""
    models = tracks.models
    if not (isinstance(models, tuple) and models and set(models) <= set(MODEL_NAMES) and len({*models}) == len(models)):
        yield Fault("shapes and types", f"models is {models!r}, not a tuple of names in MODEL_NAMES, each once")
        return
    number: dict[int | str, int] = {M: len(models), "M + 1": len(models) + 1}
    count = len(tracks.id) if isinstance(tracks.id, np.ndarray) and tracks.id.ndim == 1 else None
    for name, (shape, kinds) in SHAPES.items():
        value = getattr(tracks, name)
        wanted = (count if count is not None else "T", *(number.get(axis, axis) for axis in shape))
        if value is None and name in OPTIONAL:
            continue
        if not isinstance(value, np.ndarray):
            yield Fault("shapes and types", f"{name} is {type(value).__name__}, not an array {_shape_text(wanted)}")
        elif value.shape != wanted or value.dtype.kind not in kinds:
            numbers = "floats" if kinds == "f" else "integers"
            what = f"{name} is {value.dtype} {_shape_text(value.shape)}, not {numbers} {_shape_text(wanted)}"
            yield Fault("shapes and types", what)


def check_values(tracks: Tracks) -> Faults:
    """Check finite values, valid codes, unique ids and normalised probabilities."""
    for name in ("mean", "size"):
        yield from _invalid("values are finite", tracks, np.isfinite(getattr(tracks, name)), f"{name} is not finite")
    yield from _invalid("values are finite", tracks, tracks.size > 0, "size is not above 0")
    yield from _invalid(
        "codes are valid", tracks, np.isin(tracks.status, list(Status)), "status is not a member of Status"
    )
    yield from _invalid(
        "codes are valid", tracks, np.isin(tracks.model, range(len(tracks.models))), "model is not an index of models"
    )
    yield from _invalid("codes are valid", tracks, np.abs(tracks.corner_sign) == 1, "corner_sign is neither +1 nor -1")
    if tracks.prediction_odom is not None:
        finite = np.isfinite(tracks.prediction_odom)
        yield from _invalid("values are finite", tracks, finite, "prediction_odom is not finite")
    ids, times = np.unique(tracks.id, return_counts=True)
    if (times > 1).any():
        yield Fault("ids are unique", f"id {ids[times > 1][0]} occurs {times.max()} times")
    share = tracks.model_probability
    sums: Floats = share.sum(axis=1)
    what = "model_probability"
    yield from _invalid("probabilities sum to 1", tracks, share >= 0.0, what, lambda t: share[t].tolist())
    normalised = np.isclose(sums, 1.0, rtol=0.0, atol=TOLERANCE)
    yield from _invalid("probabilities sum to 1", tracks, normalised, f"{what} sums to", sums.item)


def check_covariances(tracks: Tracks) -> Faults:
    """Check that covariances are finite, symmetric and positive semidefinite, within the tolerance."""
    matrices = {"covariance": tracks.covariance}
    if tracks.model_covariance_odom is not None:
        models = tracks.model_covariance_odom
        matrices |= {f"model_covariance_odom of {model}": models[:, m] for m, model in enumerate(tracks.models)}
    for name, matrix in matrices.items():
        finite: Bools = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
        yield from _invalid("covariances are valid", tracks, finite, f"{name} is not finite")
        matrix = np.where(finite[:, None, None], matrix, 0.0)
        margin = TOLERANCE * np.abs(matrix).max(axis=(1, 2), initial=np.finfo(np.float64).tiny)
        skew = np.abs(matrix - matrix.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
        yield from _invalid("covariances are valid", tracks, skew <= margin, f"{name} is not symmetric")
        least = np.linalg.eigvalsh(0.5 * (matrix + matrix.swapaxes(1, 2))).min(axis=1, initial=0.0)
        what = f"{name} has a negative eigenvalue"
        yield from _invalid("covariances are valid", tracks, least >= -margin, what, lambda t: least[t])  # noqa: B023


def check_trace(trace: StepTrace, scan: Scan) -> Faults:
    """Check that labels refer to the points of this scan, and boxes to its segments."""
    label, count = trace.segments.label, trace.segments.count
    for name, values in (("segments.label", label), ("linkage.line", trace.linkage.line)):
        if np.shape(values) != (len(scan),):
            what = f"{name} has shape {_shape_text(np.shape(values))}, but the scan has {len(scan)} points"
            yield Fault("trace matches its scan", what)
            return
    if len(label) and not (label.min() >= NOT_USED and label.max() < count):
        yield Fault("trace matches its scan", f"segments.label is {label.min()} to {label.max()} for {count} segments")
    segment = trace.boxes.segment
    if len(segment) and not (segment.min() >= 0 and segment.max() < count):
        yield Fault(
            "trace matches its scan", f"boxes.segment is {segment.min()} to {segment.max()} for {count} segments"
        )
    if len(trace.track_id) != len(segment):
        yield Fault("trace matches its scan", f"track_id has {len(trace.track_id)} entries for {len(segment)} boxes")


def _invalid(
    check: str,
    tracks: Tracks,
    valid: Bools,
    what: str,
    value: Callable[[int], Any] | None = None,
) -> Faults:
    """Yield a fault that names the first track that is not valid."""
    rows = np.flatnonzero(~valid.all(axis=tuple(range(1, valid.ndim))))
    if len(rows):
        shown = f" {value(int(rows[0]))}" if value else ""
        yield Fault(check, f"track {tracks.id[rows[0]]}: {what}{shown}")


def _shape_text(shape: tuple[Any, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
