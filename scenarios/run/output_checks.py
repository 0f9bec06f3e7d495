"""Checks of a tracker's output and trace for one scan, used in every run and by `luxloop check-tracker`.

A value that a tracker does not estimate is NaN, see `Tracks.from_boxes`: velocity, acceleration, yaw rate, covariance,
and everything about models. Position, heading and size are required.
"""

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from luxloop.arrays import Bools, Floats
from luxloop.scenarios.run.user_code import reason_of
from luxloop.tracker.records import (
    METHODS,
    MODEL_NAMES,
    NOT_USED,
    PREDICTION_S,
    Boxes,
    Candidates,
    Linkage,
    Segments,
    Status,
    StepTrace,
    Tracks,
)
from luxloop.tracker.scan import Scan


class Fault(NamedTuple):
    """A failed check."""

    check: str
    what: str
    where: str = ""
    """Drive and scan, where `luxloop check-tracker` found it."""


Faults = Iterator[Fault]

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
    "small": ((), "b"),
}
"""Shape of each field of `Tracks` without its first axis, and the allowed kinds of dtype."""
OPTIONAL = ("model_covariance_odom", "model_nis", "prediction_odom", "small")
MOTION = {"velocity": slice(2, 4), "acceleration": slice(4, 6), "yaw rate": slice(7, 8)}
"""Columns of `Tracks.mean` that a tracker may leave out, each group as a whole."""
TOLERANCE = 1e-6
"""Tolerance of a sum of probabilities, and of symmetry and eigenvalues of a covariance relative to its size."""
LARGEST = 1e9
"""Largest magnitude of a number [m, s, rad], and its square that of a covariance: products of larger ones overflow in
the metrics."""
LENGTHS = ("mean", "size", "model_position_odom", "prediction_odom")
SQUARES = ("covariance", "model_covariance_odom", "model_nis")


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
        if value is not None or name not in OPTIONAL:
            yield from check_array(name, value, wanted, kinds)


def check_array(name: str, value: object, wanted: tuple[int | str, ...], kinds: str) -> Faults:
    """Check that a value is an array of a shape and of one of some kinds of dtype ("iu" integers, "f" floats)."""
    if not isinstance(value, np.ndarray):
        yield Fault("shapes and types", f"{name} is {type(value).__name__}, not an array {shape_text(wanted)}")
    elif value.shape != wanted or value.dtype.kind not in kinds:
        numbers = {"f": "floats", "b": "booleans"}.get(kinds, "integers")
        what = f"{name} is {value.dtype} {shape_text(value.shape)}, not {numbers} {shape_text(wanted)}"
        yield Fault("shapes and types", what)


def check_values(tracks: Tracks) -> Faults:
    """Check finite values, valid codes, unique ids and normalised probabilities."""
    yield from _check_numbers(tracks)
    signs = np.abs(tracks.corner_sign.astype(np.int64))
    codes = {
        "status is not a member of Status": (tracks.status >= 0) & (tracks.status < len(Status)),
        "model is not an index of models": (tracks.model >= -1) & (tracks.model < len(tracks.models)),
        "corner_sign is neither +1 nor -1": (signs == 1).all(axis=1) | (signs == 0).all(axis=1),
        "id is not from 0 to 2^63 - 1": (tracks.id >= 0) & (tracks.id <= np.iinfo(np.int64).max),
    }
    for what, valid in codes.items():
        yield from _invalid("codes are valid", tracks, valid, what)
    if tracks.prediction_odom is not None:
        finite = np.isfinite(tracks.prediction_odom)
        yield from _invalid("values are finite", tracks, finite, "prediction_odom is not finite")
    if len(set(tracks.id.tolist())) < len(tracks):
        ids, times = np.unique(tracks.id, return_counts=True)
        yield Fault("ids are unique", f"id {ids[times > 1][0]} occurs {times.max()} times")
    yield from _check_probabilities(tracks)


def _check_numbers(tracks: Tracks) -> Faults:
    """Check that the state is known, and that no number is too large."""
    check = "values are finite"
    finite = np.isfinite(tracks.mean)
    yield from _invalid(check, tracks, finite[:, [0, 1, 6]], "mean is not finite (position, heading)")
    for name, columns in MOTION.items() if not finite.all() else ():
        known = finite[:, columns].all(axis=1) | np.isnan(tracks.mean[:, columns]).all(axis=1)
        yield from _invalid(check, tracks, known, f"mean is not finite ({name}, which is NaN as a whole if unknown)")
    yield from _invalid(check, tracks, np.isfinite(tracks.size), "size is not finite")
    yield from _invalid(check, tracks, ~(tracks.size <= 0), "size is not above 0")
    for names, largest in ((LENGTHS, LARGEST), (SQUARES, LARGEST**2)):
        for name in names:
            if (values := getattr(tracks, name)) is not None:
                judged = np.isfinite(values) if "covariance" in name else True  # `check_covariances` has the others
                too_large = judged & (np.abs(values) > largest)
                yield from _invalid(check, tracks, ~too_large, f"{name} is beyond {largest:g}")


def _check_probabilities(tracks: Tracks) -> Faults:
    check, what, share = "probabilities sum to 1", "model_probability", tracks.model_probability
    unknown: Bools = np.asarray(np.isnan(share).all(axis=1))
    yield from _invalid(check, tracks, (share >= 0.0) | unknown[:, None], what, lambda t: share[t].tolist())
    sums: Floats = share.sum(axis=1)
    normalised = (np.abs(sums - 1.0) <= TOLERANCE) | unknown
    yield from _invalid(check, tracks, normalised, f"{what} sums to", sums.item)


def check_covariances(tracks: Tracks, *, definite: bool = True) -> Faults:
    """Check that covariances are finite, symmetric and, if `definite`, positive semidefinite, within the tolerance."""
    check = "covariances are valid"
    for name, matrix in _covariances(tracks).items():
        if not definite and np.isfinite(matrix).all() and (matrix == matrix.swapaxes(1, 2)).all():
            continue
        finite: Bools = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
        unknown: Bools = np.asarray(np.isnan(matrix).all(axis=(1, 2)))
        yield from _invalid(check, tracks, finite | unknown, f"{name} is not finite")
        matrix = np.where(finite[:, None, None], matrix, 0.0)
        margin = TOLERANCE * np.abs(matrix).max(axis=(1, 2), initial=np.finfo(np.float64).tiny)
        skew = np.abs(matrix - matrix.swapaxes(1, 2)).max(axis=(1, 2), initial=0.0)
        yield from _invalid(check, tracks, skew <= margin, f"{name} is not symmetric")
        if definite:
            least = np.linalg.eigvalsh(0.5 * (matrix + matrix.swapaxes(1, 2))).min(axis=1, initial=0.0)
            what = f"{name} has a negative eigenvalue"
            yield from _invalid(check, tracks, least >= -margin, what, lambda t: least[t])  # noqa: B023


def _covariances(tracks: Tracks) -> dict[str, Floats]:
    """Return the covariances by name, each (T, K, K)."""
    matrices = {"covariance": tracks.covariance}
    if tracks.model_covariance_odom is not None:
        models = tracks.model_covariance_odom
        matrices |= {f"model_covariance_odom of {model}": models[:, m] for m, model in enumerate(tracks.models)}
    return matrices


def _invalid(
    check: str, tracks: Tracks, valid: npt.ArrayLike, what: str, value: Callable[[int], Any] | None = None
) -> Faults:
    """Yield a fault that names the first track that is not valid."""
    passed = np.asarray(valid, np.bool_)
    if passed.all():
        return
    row = int(np.flatnonzero(~passed.all(axis=tuple(range(1, passed.ndim))))[0])
    shown = f" {value(row)}" if value else ""
    yield Fault(check, f"track {tracks.id[row]}: {what}{shown}")


def shape_text(shape: tuple[Any, ...]) -> str:
    """Return a shape as Python writes it."""
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


TRACE_CHECK = "trace matches its scan"

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
FLOATS = [name for name, (_, kinds) in (SEGMENT_ARRAYS | BOX_ARRAYS).items() if kinds == "f"]


def check_trace(trace: StepTrace, scan: Scan) -> Faults:
    """Check that labels refer to the points of this scan, and boxes to its segments."""
    label, count = trace.segments.label, trace.segments.count
    for name, values in (("segments.label", label), ("linkage.line", trace.linkage.line)):
        if np.shape(values) != (len(scan),):
            what = f"{name} has shape {shape_text(np.shape(values))}, but the scan has {len(scan)} points"
            yield Fault(TRACE_CHECK, what)
            return
    if len(label) and not (label.min() >= NOT_USED and label.max() < count):
        yield Fault(TRACE_CHECK, f"segments.label is {label.min()} to {label.max()} for {count} segments")
    best, methods = trace.candidates.best, trace.candidates.heading.shape[1]
    if len(best) and not (best.min() >= 0 and best.max() < methods):
        yield Fault(TRACE_CHECK, f"candidates.best is {best.min()} to {best.max()} for {methods} methods")
    segment = trace.boxes.segment
    if not len(segment) <= count <= len(scan):
        yield Fault(TRACE_CHECK, f"{len(segment)} boxes of {count} segments of {len(scan)} points; one may have one")
    if len(segment) and not (segment.min() >= 0 and segment.max() < count):
        yield Fault(TRACE_CHECK, f"boxes.segment is {segment.min()} to {segment.max()} for {count} segments")
    if len(trace.track_id) != len(segment):
        yield Fault(TRACE_CHECK, f"track_id has {len(trace.track_id)} entries for {len(segment)} boxes")
    for name in FLOATS:
        if np.any(np.abs(_field(trace, name)) > LARGEST**2):  # not NaN: a value that is not estimated
            yield Fault(TRACE_CHECK, f"{name} is beyond {LARGEST**2:g}")


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


TRACKS_MAX = 10_000
"""Largest number of tracks in a frame: grading compares all pairs of tracks and vehicles."""
MORE = "luxloop check-tracker shows more"
RECORDS = (Tracks, StepTrace, Segments, Linkage, Candidates, Boxes)
TYPES = {"id": np.int64, "status": np.uint8, "model": np.int64, "corner_sign": np.int64, "small": np.bool_}
"""Types of the integer and boolean fields of `Tracks` in the harness; all others are float64."""


class BrokenOutputError(Exception):
    """An output breaks the contract; the message names the field."""


class OutputCheck:
    """Check of the outputs of one tracker, whose models keep one order."""

    def __init__(self) -> None:
        self._models: tuple[str, ...] | None = None

    def checked(self, output: object, scan: Scan) -> tuple[Tracks, StepTrace | None]:
        """Return copies of tracks and trace; the trace is None if there is none.

        Raises
        ------
        BrokenOutputError
            They break the contract.
        """
        trace: StepTrace | None = None
        match output:
            case Tracks() as tracks:
                pass
            case (Tracks() as tracks, StepTrace() as trace):
                pass
            case other:
                raise BrokenOutputError(f"returned {type(other).__name__}; return Tracks or (Tracks, StepTrace)")
        try:
            return self._checked_tracks(tracks), _checked_trace(trace, scan) if trace else None
        except (BrokenOutputError, KeyboardInterrupt):
            raise
        except BaseException as error:  # fields are missing, or properties that fail
            what = f"returned a record that cannot be read ({reason_of(error)}); {MORE}"
            raise BrokenOutputError(what) from error

    def _checked_tracks(self, tracks: Tracks) -> Tracks:
        if len(np.shape(tracks.id)) == 1 and len(tracks.id) > TRACKS_MAX:
            raise BrokenOutputError(f"id: {len(tracks.id)} tracks; at most {TRACKS_MAX} can be graded")
        _require(check_shapes(tracks))
        copy: Tracks = copied(tracks)
        _require(check_values(copy))
        _require(check_covariances(copy, definite=False))
        if tracks.models != (self._models or tracks.models):
            raise BrokenOutputError(
                f"models is {tracks.models}, but was {self._models} before; keep one order in all frames"
            )
        self._models = copy.models
        return replace(copy, **{name: _converted(name, getattr(copy, name)) for name in SHAPES})


def _checked_trace(trace: StepTrace, scan: Scan) -> StepTrace:
    _require(check_trace_shapes(trace))
    copy: StepTrace = copied(trace)
    _require(check_trace(copy, scan))
    return copy


def _require(faults: Faults) -> None:
    for fault in faults:
        raise BrokenOutputError(f"{fault.what}; {MORE}")


def read_only(scan: Scan) -> Scan:
    """Return a copy of a scan whose arrays refuse to be written to."""
    return locked(Scan(**{name: copied(getattr(scan, name)) for name in fields_of(scan)}))


def locked(scan: Scan) -> Scan:
    """Let the arrays of a scan refuse to be written to, and return it."""
    for name in fields_of(scan):
        if isinstance(value := getattr(scan, name), np.ndarray):
            value.setflags(write=False)
    return scan


def fields_of(record: Any) -> list[str]:
    """Return the names of the fields of a record."""
    return [field.name for field in fields(record)]


def _converted(name: str, array: Any) -> Any:
    """Return a field of `Tracks` in the harness's type."""
    return None if array is None else array.astype(TYPES.get(name, np.float64), copy=False)


def copied(value: Any) -> Any:
    """Return a deep copy of a record, as one of `RECORDS`; subclasses of records and arrays become these."""
    if isinstance(value, np.ndarray):
        return np.array(value)
    for record in RECORDS:
        if isinstance(value, record):
            return record(**{name: copied(getattr(value, name)) for name in fields_of(record)})
    return value
