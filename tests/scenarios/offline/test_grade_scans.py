"""Recorded scans: exactly the frames, scans and truth of the run."""

import shutil
from dataclasses import fields, is_dataclass

import numpy as np
import pytest
from support import short_run
from support.few import few

from luxloop.scenarios import execute
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.offline import recorded_scans
from luxloop.scenarios.offline.recorded_scans import RecordedRun, RecordedScans
from luxloop.scenarios.run import device, loop
from luxloop.scenarios.run.trace_hash import TraceHash

SUMO_S = 1.2
UNITS = 6


def assert_same(one, other, path=""):
    """Assert that two records are equal: types, shapes, and every bit."""
    assert type(one) is type(other), path
    if is_dataclass(one):
        for field in fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name), f"{path}.{field.name}")
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), path
        assert one.tobytes() == other.tobytes(), path
    else:
        assert one == other, path


def recorded(tmp_path_factory, scenario):
    """Return a run folder with scans, its result, and the live records of the same run."""
    out, live = tmp_path_factory.mktemp("recorded") / "run", []
    result = execute.execute(scenario, device.load(device.SHIPPED), out, record=False, record_scans=True)
    loop.run(scenario, device.load(device.SHIPPED), export=lambda *records: live.append(records[:3]))
    return out, result, live


@pytest.fixture(scope="module")
def scripted(tmp_path_factory):
    return recorded(tmp_path_factory, Scenario.load(short_run.write(tmp_path_factory.mktemp("scenario"))))


@pytest.fixture(scope="module")
def sumo(tmp_path_factory):
    return recorded(tmp_path_factory, Scenario.load(shipped.find("sumo-crossing"), {"duration_s": SUMO_S}))


@pytest.mark.parametrize("run", ["scripted", "sumo"])
@pytest.mark.parametrize("rows_at_once", few([100, recorded_scans.ROWS_AT_ONCE], 100))
def test_recorded_scans_equal_the_simulated_ones(run, rows_at_once, request, monkeypatch):
    """Fails if a column is missing, swapped or narrowed, or rows are assigned to the wrong frame."""
    monkeypatch.setattr(recorded_scans, "ROWS_AT_ONCE", rows_at_once)
    out, result, live = request.getfixturevalue(run)
    back = list(RecordedRun.open(out).scans())
    assert len(back) == len(live) == result.frames
    for read, simulated in zip(back, live, strict=True):
        for one, other in zip(read, simulated, strict=True):
            assert_same(one, other, type(one).__name__)


def test_the_tracker_gives_the_same_trace_on_recorded_scans(sumo):
    """The trace hash over recorded scans and new tracks equals that of the live run."""
    out, result, _ = sumo
    tracker, trace_hash = device.load(device.SHIPPED)(Scenario.load(shipped.find("sumo-crossing")).tracker), TraceHash()
    for frame, scan, truth in RecordedRun.open(out).scans():
        tracks, _ = tracker.step(scan)
        trace_hash.add(frame, scan, truth, tracks)
    assert trace_hash.hexdigest() == result.trace_hash


def test_recorded_scans_have_the_fields_of_view_and_the_units_of_their_run(scripted):
    """The lower layers of a LUX cover 50 to -50 degrees, the upper ones 34.75 to -59.75, at 4500 degrees per second."""
    out, result, live = scripted
    for (_, scan, _), (_, simulated, _) in zip(RecordedRun.open(out).scans(), live, strict=True):
        assert scan.sweep_limits.shape == (UNITS, 4, 2)
        np.testing.assert_array_equal(scan.sweep_limits, simulated.sweep_limits)
        np.testing.assert_allclose(scan.sweep_limits[0, :2] * 4500.0, [[-50.0, 50.0]] * 2, atol=1e-3)
        np.testing.assert_allclose(scan.sweep_limits[0, 2:] * 4500.0, [[-34.75, 59.75]] * 2, atol=1e-3)
        np.testing.assert_array_equal(scan.unit_positions_ego, simulated.unit_positions_ego)
    _, unlimited, _ = next(iter(RecordedScans(out, result.frames, UNITS)))
    assert unlimited.sweep_limits is None
    assert unlimited.unit_positions_ego is None


def test_recorded_arrays_are_writeable_and_contiguous_like_live_ones(scripted):
    """Kernels are compiled again for arrays that are read-only or not contiguous."""
    out, result, _ = scripted
    for _, scan, _ in RecordedScans(out, result.frames, UNITS):
        for field in ("points_ego", "time_offset", "unit", "ego_pose_odom"):
            array = getattr(scan, field)
            assert array.flags.writeable
            assert array.flags.c_contiguous


def test_frames_without_points_or_actors_can_be_read(tmp_path_factory, tmp_path):
    text = short_run.TEXT.partition("[[traffic.actor]]")[0]
    scenario = Scenario.load(short_run.write(tmp_path, text))
    out, _, live = recorded(tmp_path_factory, scenario)
    assert not len(live[0][0].actors)
    for read, simulated in zip(RecordedRun.open(out).scans(), live, strict=True):
        for one, other in zip(read, simulated, strict=True):
            assert_same(one, other, type(one).__name__)


def test_a_run_without_scans_is_an_error_with_the_remedy(tmp_path):
    with pytest.raises(OutputError, match="has no recorded scans; run the scenario again with --record-scans"):
        RecordedScans(tmp_path, 10, UNITS)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda folder: (folder / "points.parquet").unlink(), "points.parquet"),
        (lambda folder: (folder / "labels.parquet").write_bytes(b"PAR1"), "cannot be read"),
        (lambda folder: (folder / "scans.parquet").write_text(""), "cannot be read"),
    ],
    ids=["missing", "cut off", "empty"],
)
def test_damaged_scans_are_a_one_line_error(damage, message, scripted, tmp_path):
    shutil.copytree(scripted[0] / "scans", tmp_path / "scans")
    damage(tmp_path / "scans")
    with pytest.raises(OutputError, match=message) as error:
        list(RecordedScans(tmp_path, scripted[1].frames, UNITS))
    assert "\n" not in str(error.value)


def test_scans_of_another_run_are_refused(scripted):
    with pytest.raises(OutputError, match="has 10 frames, but the run has 11"):
        RecordedScans(scripted[0], scripted[1].frames + 1, UNITS)
