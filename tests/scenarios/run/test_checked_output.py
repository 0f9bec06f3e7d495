"""Outputs of trackers with numbers that no metric survives, and messages that are no record."""

import json
import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.frames import Body, Scripted, follow, grade_run, observe, trace_of, tracks_of, world_frame

from luxloop.scenarios.run.output_checks import BrokenOutputError, OutputCheck
from luxloop.scenarios.run.record_messages import HEAD, decode, encode

BODIES = [Body(1, 12.0, 3.0), Body(2, 20.0, -4.0)]


@cache
def output():
    """A scan of two cars, and their tracks and trace."""
    frame = world_frame(0, BODIES)
    scan, truth = observe(frame, BODIES)
    return scan, tracks_of([follow(body) for body in BODIES]), trace_of(frame, truth)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"model_position_odom": np.full((2, 3, 2), 1e308)}, "track 1: model_position_odom is beyond 1e"),
        ({"model_position_odom": np.full((2, 3, 2), np.inf)}, "track 1: model_position_odom is beyond 1e"),
        ({"prediction_odom": np.full((2, 4, 3, 2), -1e300)}, "track 1: prediction_odom is beyond 1e"),
        ({"covariance": np.full((2, 8, 8), 1e300)}, "track 1: covariance is beyond 1e"),
        ({"model_covariance_odom": np.full((2, 3, 2, 2), 1e300)}, "track 1: model_covariance_odom is beyond 1e"),
        ({"model_nis": np.full((2, 3), np.inf)}, "track 1: model_nis is beyond 1e"),
    ],
)
def test_numbers_that_overflow_in_metrics_are_refused(fields, message):
    scan, tracks, _ = output()
    with pytest.raises(BrokenOutputError) as refusal:
        OutputCheck().checked(replace(tracks, **fields), scan)
    assert message in str(refusal.value)


@pytest.mark.parametrize(
    ("record", "fields", "message"),
    [
        ("candidates", {"best": np.array([0, 5])}, "candidates.best is 0 to 5 for 5 methods"),
        ("candidates", {"best": np.array([-1, 0])}, "candidates.best is -1 to 0 for 5 methods"),
        ("candidates", {"size": np.full((2, 5, 2), 1e300)}, "candidates.size is beyond 1e"),
        ("candidates", {"heading": np.full((2, 5), np.inf)}, "candidates.heading is beyond 1e"),
        ("boxes", {"center_ego": np.full((2, 2), -1e300)}, "boxes.center_ego is beyond 1e"),
        ("boxes", {"segment": np.zeros(3, np.int64)}, "boxes.center_ego is float64 (2, 2), not floats (3, 2)"),
    ],
)
def test_traces_that_grading_cannot_take_are_refused(record, fields, message):
    scan, tracks, trace = output()
    odd = replace(trace, **{record: replace(getattr(trace, record), **fields)})
    with pytest.raises(BrokenOutputError) as refusal:
        OutputCheck().checked((tracks, odd), scan)
    assert message in str(refusal.value)


def test_a_segment_has_one_box_at_most():
    scan, tracks, trace = output()
    twice = np.array([0, 0, 1])
    odd = replace(trace, boxes=trace.boxes.subset(twice), track_id=trace.track_id[twice])
    with pytest.raises(BrokenOutputError, match=f"3 boxes of 2 segments of {len(scan)} points"):
        OutputCheck().checked((tracks, odd), scan)


def test_a_record_whose_properties_end_the_process_is_refused():
    scan, tracks, _ = output()

    class Ends(type(tracks)):
        @property
        def mean(self):
            raise BaseException

    odd = object.__new__(Ends)
    for name in tracks.__dataclass_fields__.keys() - {"mean"}:
        object.__setattr__(odd, name, getattr(tracks, name))
    with pytest.raises(BrokenOutputError, match="cannot be read"):
        OutputCheck().checked(odd, scan)


def test_a_box_of_no_variance_is_outside_its_interval_without_a_warning():
    """The error of the first box is 0, which is inside; negative variances count as 0."""

    def certain(frame, truth):
        trace = trace_of(frame, truth)
        turned = replace(trace.boxes, heading=np.array([0.0, 0.1]), covariance=np.stack([0 * np.eye(3), -np.eye(3)]))
        return replace(trace, boxes=turned)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        metrics = grade_run([BODIES], Scripted([[follow(body) for body in BODIES]]), trace=certain)[0]
    assert metrics["fit.coverage_90"].value == 0.5


def message(head, body=b""):
    text = head if isinstance(head, bytes) else json.dumps(head).encode()
    return HEAD.pack(len(text)) + text + body


ARRAY = {"type": "<f8", "shape": [2]}


@pytest.mark.parametrize(
    "body",
    [
        b"",
        message(b"[" * 60_000),
        message(b"[" + b"[]," * 100_000 + b"[]]"),
        message([]),
        message({"tracks": []}),
        message({"tracks": {"id": {**ARRAY, "type": "f4,(f4"}}}),
        message({"tracks": {"id": {**ARRAY, "type": ["<f8"]}}}),
        message({"tracks": {"id": {**ARRAY, "shape": [0, 2**62, 2**62]}}}),
        message({"tracks": {"id": {**ARRAY, "shape": [-1, -16]}}}, bytes(128)),
        message({"tracks": {"id": ARRAY}}),
        message(b'{"tracks": {"id": {"value": Infinity}}}'),
        message({"tracks": {"__class__": {"value": 1}}}),
    ],
)
def test_bytes_that_are_no_record_are_refused(body):
    with pytest.raises(ValueError, match="answered no record"):
        decode(body)


def test_a_long_head_is_not_parsed():
    with pytest.raises(ValueError, match="a head of 300004 bytes"):
        decode(message(b"[" + b"[]," * 100_000 + b"[]]"))


def test_a_record_is_read_as_it_was_written():
    _, tracks, trace = output()
    read, traced = decode(encode(tracks, trace))
    assert read.models == tracks.models
    np.testing.assert_array_equal(read.mean, tracks.mean)
    np.testing.assert_array_equal(traced.boxes.cut, trace.boxes.cut)
