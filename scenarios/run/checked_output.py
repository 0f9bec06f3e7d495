"""Outputs of trackers: copies, checked before use."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from luxloop.scenarios.run.output_checks import (
    SHAPES,
    Faults,
    check_covariances,
    check_shapes,
    check_trace,
    check_trace_shapes,
    check_values,
)
from luxloop.scenarios.run.user_code import text_of
from luxloop.tracker.records import Boxes, Candidates, Linkage, Segments, StepTrace, Tracks
from luxloop.tracker.scan import Scan

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
            what = f"returned a record that cannot be read ({type(error).__name__}: {text_of(error)}); {MORE}"
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
