"""Recording written by rerun and read back with rerun's reader."""

import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from support import short_run
from support.drive import DT, HIDDEN, IDS, START, Step, buildings, drive, turned

from luxloop.scenarios.control.ego_driver import Decision, LeadVehicle
from luxloop.scenarios.rerun_log import blueprint as look
from luxloop.scenarios.rerun_log.recorded_points import read_points
from luxloop.scenarios.rerun_log.recorder import INDEXED_FRAMES, Recorder
from luxloop.sensor_model.truth import Cause
from luxloop.sim.world import Kind, Obstacles

FRAMES = 24
EVERY_FRAME = [
    "/world/ego", "/world/odom", "/world/truth", "/world/ego/points", "/world/ego/fits", "/world/odom/tracks",
    "/world/odom/tracks/names", "/world/odom/velocities", "/world/odom/trails", *(f"/{path}" for path in look.PLOTS),
]  # fmt: skip


def record(path: Path, steps: list[Step], obstacles: Obstacles | None = None, frames: int = 0) -> Path:
    recorder = Recorder(path, "test", obstacles or buildings(), frames=frames)
    for step in steps:
        recorder.log(*step)
    recorder.close()
    return path


def read(path: Path, entity: str, *, static: bool = False) -> dict[str, list[Any]]:
    """Return the rows of an entity by column, in the order of frames."""
    from rerun.chunk import RrdReader

    columns: dict[str, list[Any]] = {}
    for chunk in RrdReader(path).stream():
        if chunk.entity_path == entity and chunk.is_static == static:
            for name, values in chunk.to_record_batch().to_pydict().items():
                columns.setdefault(name, []).extend(values)
    return columns


def rgb(color: int) -> tuple[int, ...]:
    return tuple(color.to_bytes(4, "big")[:3])


def applied(transform: dict[str, list[Any]], row: int, xy: np.ndarray) -> np.ndarray:
    """Transform (N, 2) points by a recorded transform."""
    yaw = transform["Transform3D:rotation_axis_angle"][row][0]["angle"]
    return turned(xy, yaw) + np.array(transform["Transform3D:translation"][row][0])[:2]


@pytest.fixture(scope="module")
def steps() -> list[Step]:
    return list(drive(FRAMES))


@pytest.fixture(scope="module")
def recording(steps: list[Step], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("recording") / "recording.rrd", steps)


def test_rerun_verifies_the_closed_file(recording: Path) -> None:
    # Fails when the file is left without its footer, or before the last batch is flushed.
    verified = verify(recording)
    assert verified.returncode == 0, verified.stderr
    assert "1 file verified without error" in verified.stdout + verified.stderr


def verify(path: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "rerun_cli", "rrd", "verify", str(path)], capture_output=True, text=True
    )


def has_index(path: Path) -> bool:
    return "Missing RRD footer" not in verify(path).stderr


@pytest.mark.parametrize("longest", [9, 10])
def test_a_run_with_more_frames_than_indexed_has_no_index(longest, tmp_path, monkeypatch):
    monkeypatch.setattr("luxloop.scenarios.rerun_log.recorder.INDEXED_FRAMES", longest)
    short_run.run(record_to=tmp_path / "run.rrd")
    assert has_index(tmp_path / "run.rrd") is (longest == 10)


@pytest.mark.filterwarnings("error")
def test_a_long_recording_has_no_index_and_is_read_as_any_other(
    recording: Path, steps: list[Step], tmp_path: Path
) -> None:
    # Fails when rerun holds an entry of each chunk in memory, or when reading prints its warning.
    path = tmp_path / "long.rrd"
    record(path, steps, frames=INDEXED_FRAMES + 1)
    assert not has_index(path)
    points = read_points(path, range(FRAMES))
    assert len(points)
    pd.testing.assert_frame_equal(points, read_points(recording, range(FRAMES)))


@pytest.mark.parametrize("entity", EVERY_FRAME)
def test_every_frame_is_on_both_timelines(recording: Path, entity: str) -> None:
    # Fails when the last frames are lost, or a wall-clock timeline is recorded.
    rows = read(recording, entity)
    assert rows["frame"] == list(range(FRAMES))
    seconds = [time / np.timedelta64(1, "s") for time in np.array(rows["sim_time"], dtype="m8[ns]")]
    np.testing.assert_allclose(seconds, DT * np.arange(FRAMES), atol=1e-6)
    assert not {"log_time", "log_tick"} & rows.keys()


def test_truth_keeps_its_precision_far_from_the_worlds_origin(recording: Path, steps: list[Step]) -> None:
    # Fails without the shift of the origin: at 52 km, float32 has a resolution of 4 mm.
    truth = read(recording, "/world/truth")
    for row, step in enumerate(steps):
        expected = step.frame.actors.pose_world[:, :2] - START[:2]
        centers = np.array(truth["Boxes3D:centers"][row])
        np.testing.assert_allclose(centers[:, :2], expected, atol=1e-5)
        np.testing.assert_allclose(centers[:, 2], 0.5 * step.frame.actors.size[:, 2], atol=1e-6)
        x, y, z, w = np.array(truth["Boxes3D:quaternions"][row]).T
        turn = np.exp(1j * step.frame.actors.pose_world[:, 2])
        np.testing.assert_allclose((w + 1j * z) ** 2, turn, atol=1e-6)
        assert not x.any()
        assert not y.any()
    assert truth["Boxes3D:labels"][0] == [f"flow.{index}" for index in range(len(IDS))]


def test_truth_is_coloured_by_visible_fraction_and_dim_when_ungraded(recording: Path) -> None:
    # Fails when the colours are swapped. Actor 0 has visible fraction 0.5, and is not graded while hidden.
    colors = read(recording, "/world/truth")["Boxes3D:colors"]
    half = np.mean([look.HIDDEN, look.VISIBLE], axis=0)
    assert rgb(colors[0][0]) == tuple(half.astype(int))
    assert rgb(colors[HIDDEN[0]][0]) == tuple((look.DIM * half).astype(int))
    assert {rgb(color) for color in colors[0][1:]} == {look.VISIBLE}


def test_tracks_are_on_their_actors_despite_odometry_drift(recording: Path, steps: list[Step]) -> None:
    # Fails when tracks are drawn in a fixed odometry frame, or at their corner.
    ego, odom = read(recording, "/world/ego"), read(recording, "/world/odom")
    tracks, fits = read(recording, "/world/odom/tracks"), read(recording, "/world/ego/fits")
    for row, step in enumerate(steps):
        expected = step.frame.actors.pose_world[:, :2] - START[:2]
        track_centers = np.array(tracks["Boxes3D:centers"][row])[:, :2]
        np.testing.assert_allclose(applied(odom, row, track_centers), expected, atol=1e-4)
        fit_centers = np.array(fits["Boxes3D:centers"][row])[:, :2]
        seen = expected[step.grade.graded]
        np.testing.assert_allclose(applied(ego, row, fit_centers), seen, atol=1e-4)


def test_coasting_track_is_labelled_and_dim(recording: Path) -> None:
    # Fails when status is not shown, or when tentative tracks get names.
    tracks, names = read(recording, "/world/odom/tracks"), read(recording, "/world/odom/tracks/names")
    labels = names["Points3D:labels"]
    assert labels[0] == [""] * 6
    assert labels[5] == ["0 cv", "1 cv", "2 cv", "3 cv", "4 cv", "5 st"]
    assert labels[HIDDEN[0]][0] == "0 coasting"
    assert rgb(names["Points3D:colors"][5][0]) == (255, 255, 255)  # colours of tracks are unreadable on mid grey
    bright, dim = (np.array(rgb(tracks["Boxes3D:colors"][row][0])) for row in (5, HIDDEN[0]))
    np.testing.assert_array_equal(dim, (look.DIM * bright).astype(int))
    assert abs(tracks["Boxes3D:radii"][HIDDEN[0]][0]) < abs(tracks["Boxes3D:radii"][5][0])


def test_trails_are_continuous(recording: Path) -> None:
    # Fails when steps of tracks are exchanged, or a new track's trail starts at the origin.
    trails = np.array(read(recording, "/world/odom/trails")["LineStrips3D:strips"])
    np.testing.assert_array_equal(trails[0, :, 0], trails[0, :, 1])
    np.testing.assert_array_equal(trails[1:, :, 0], trails[:-1, :, 1])


def test_points_carry_cause_unit_and_layer_with_one_set_of_positions(recording: Path, steps: list[Step]) -> None:
    # Fails when a colouring uses the wrong array, or clean background points have the class of vehicles.
    points = read(recording, "/world/ego/points")
    for row, step in enumerate(steps):
        np.testing.assert_array_equal(np.array(points["Points3D:positions"][row], np.float32), step.scan.points_ego)
        ids = np.array(points["Points3D:class_ids"][row])
        on_actor = step.scan_truth.actor_id >= 0
        np.testing.assert_array_equal(ids[on_actor], step.scan_truth.cause[on_actor])
        assert set(ids[~on_actor]) == {look.BACKGROUND}
        for name, index in (("by:unit", step.scan.unit), ("by:layer", step.scan.layer)):
            assert [rgb(color) for color in points[name][row]] == [look.CYCLE[i] for i in index]
    assert {int(cause) for cause in Cause} == set(look.CAUSES)


def test_plots_hold_the_numbers_of_the_frame(recording: Path, steps: list[Step]) -> None:
    # Fails when averages include tentative or coasting tracks, or radians are plotted.
    def plot(name: str, row: int) -> list[float]:
        return list(read(recording, f"/plots/{name}")["Scalars:scalars"][row])

    absent = [np.nan] * 3  # turning models, which are not in the bank
    np.testing.assert_allclose(plot("models_moving", 5), [0.1, 0.7, 0.2, *absent])
    np.testing.assert_allclose(plot("models_standing", 5), [0.9, 0.06, 0.04, *absent])
    assert np.isnan(plot("models_moving", 0)).all()
    np.testing.assert_allclose(plot("heading_error", 5), [0.5, 3.5])
    np.testing.assert_allclose(plot("heading_error", HIDDEN[0]), [0.5, 4.0])
    assert plot("counts", 5) == [6, 6, 0]
    assert plot("counts", HIDDEN[0]) == [5, 5, 1]
    assert plot("points", 5) == [300, np.count_nonzero(steps[5].scan_truth.cause)]


def test_events_are_written_at_their_frame(recording: Path) -> None:
    # Fails when the events are not in the file, or all at its start.
    events = read(recording, "/events")
    log = list(zip(events["frame"], events["TextLog:level"], events["TextLog:text"], strict=True))
    assert (3, ["INFO"], ["track 0 confirmed on flow.0"]) in log
    assert any(HIDDEN[0] < frame < HIDDEN[-1] and level == ["WARN"] for frame, level, _ in log)
    assert (HIDDEN[-1] + 1, ["INFO"], ["track 0 back after 0.9 s, on flow.0"]) in log


def test_walls_are_at_the_obstacles(recording: Path) -> None:
    # Fails when polygons are not closed, are connected with each other, or keep world coordinates.
    mesh = read(recording, "/world/obstacles", static=True)
    corners = np.array(mesh["Mesh3D:vertex_positions"][0])
    triangles = corners[np.array(mesh["Mesh3D:triangle_indices"][0])]
    area = 0.5 * np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    house, both_sides_of_the_wall = 2 * (25.0 + 20.0) * look.WALL_TOP_M, 2 * 40.0 * 1.0
    np.testing.assert_allclose(area.sum(), house + both_sides_of_the_wall, rtol=1e-5)
    np.testing.assert_allclose(corners.min(axis=0), [-10.0, -20.0, 0.0], atol=1e-4)
    np.testing.assert_allclose(corners.max(axis=0), [45.0, 60.0, look.WALL_TOP_M], atol=1e-4)


def test_layout_is_in_the_file_and_shows_recorded_paths_only(recording: Path) -> None:
    # Fails when a view or an override refers to a path without data: the view would be empty.
    from rerun.chunk import RrdReader

    logged = {str(chunk.entity_path) for chunk in RrdReader(recording).stream()}
    (layout,) = RrdReader(recording).blueprints()
    names = []
    for chunk in RrdReader(recording).stream(store=layout):
        columns = chunk.to_record_batch().to_pydict()
        if "ViewBlueprint:space_origin" in columns:
            names += columns["ViewBlueprint:display_name"][0]
            assert f"/{columns['ViewBlueprint:space_origin'][0][0]}" in logged
        _, is_override, path = str(chunk.entity_path).partition("/overrides")
        if is_override:
            assert path.partition("/visualizers")[0] in logged
        for mapping in columns.get("VisualizerInstruction:component_map", []):
            assert mapping[0]["source_component"] in read(recording, "/world/ego/points")
    assert {"Points by cause", "Points by unit", "Points by layer", "Events", "Legend"} <= set(names)


def test_legend_and_names_of_lines(recording: Path) -> None:
    # Fails when the numbers of lines and names differ: rerun would draw lines without names.
    for path, lines in look.PLOTS.items():
        assert read(recording, f"/{path}", static=True)["SeriesLines:names"] == [list(lines)]
        assert len(read(recording, f"/{path}")["Scalars:scalars"][0]) == len(lines)
    assert read(recording, "/legend", static=True)["TextDocument:text"] == [[look.LEGEND]]


def test_simultaneous_recordings_are_independent(steps: list[Step], tmp_path: Path) -> None:
    # Fails when rerun's global recording is used.
    one, two = (Recorder(tmp_path / name, name, buildings()) for name in ("one.rrd", "two.rrd"))
    for step in steps[:4]:
        one.log(*step)
        two.log(*step)
        two.log(*step)
    one.close()
    two.close()
    two.close()  # a second call has no effect
    assert len(read(tmp_path / "one.rrd", "/world/ego")["frame"]) == 4
    assert len(read(tmp_path / "two.rrd", "/world/ego")["frame"]) == 8


def test_empty_world_and_tracker_without_trace(steps: list[Step], tmp_path: Path) -> None:
    # Fails when the recorder requires at least one actor, point, track or obstacle.
    first = steps[0]
    empty = Step(
        frame=replace(first.frame, actors=none_of(first.frame.actors)),
        scan=replace(none_of(first.scan, keep="ego_pose_odom"), time=0.0),
        scan_truth=none_of(first.scan_truth),
        tracks=none_of(first.tracks),
        trace=None,
        grade=none_of(first.grade),
    )
    path = record(tmp_path / "empty.rrd", [empty], Obstacles.from_polygons([], []))
    assert read(path, "/world/truth")["Boxes3D:centers"] == [[]]
    assert read(path, "/world/odom/tracks")["Boxes3D:centers"] == [[]]
    assert np.isnan(read(path, "/plots/heading_error")["Scalars:scalars"][0]).all()
    assert not read(path, "/world/ego/fits")


def none_of(record: Any, keep: str = "") -> Any:
    """Return a record with all arrays of length 0."""
    arrays = {f.name: getattr(record, f.name) for f in fields(record) if f.name != keep}
    return replace(record, **{name: array[:0] for name, array in arrays.items() if isinstance(array, np.ndarray)})


def test_size_stays_within_60_mb_for_40_s(tmp_path: Path) -> None:
    # Fails when positions are stored once per colouring (22 bytes a point became 46).
    path = record(tmp_path / "size.rrd", list(drive(30, points=2500)))
    assert path.stat().st_size / 30 * 500 < 40e6


def test_speeds_and_gap_of_a_controlled_ego_are_plotted(steps: list[Step], tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "controlled.rrd", "test", buildings(), controlled=True)
    for step, lead in zip(steps[:3], (None, LeadVehicle(4, 12.5, 8.0), None), strict=True):
        recorder.log(*step, Decision(9.5, lead) if step is not steps[0] else None)
    recorder.close()
    rows = read(tmp_path / "controlled.rrd", f"/{look.CONTROL}")
    assert rows["frame"] == [1, 2]  # the first frame has no decision
    np.testing.assert_allclose(rows["Scalars:scalars"], [[8.0, 9.5, 12.5], [8.0, 9.5, np.nan]])


def test_running_without_a_recording_does_not_import_rerun() -> None:
    # Fails without the lazy import: half a second for every `luxloop` command.
    code = (
        "import sys; from luxloop.scenarios.rerun_log.recorder import NullRecorder as N; N().close();"
        "print('rerun' in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert ran.stdout == "False\n"


def test_bent_truck_is_drawn_as_trailer_and_tractor(steps: list[Step], tmp_path: Path) -> None:
    # Fails when the tractor is not rotated, or has the colour or the name of another actor.
    step = steps[5]
    articulation = np.where(step.frame.actors.id == IDS[1], 0.5, 0.0)
    kind = np.where(articulation > 0.0, Kind.TRAILER_TRUCK, step.frame.actors.kind).astype(np.uint8)
    frame = replace(step.frame, actors=replace(step.frame.actors, articulation=articulation, kind=kind))
    truth = read(record(tmp_path / "bent.rrd", [step._replace(frame=frame)]), "/world/truth")
    centers, names = np.array(truth["Boxes3D:centers"][0]), truth["Boxes3D:labels"][0]
    assert names == [*(f"flow.{row}" for row in range(6)), "flow.1"]
    assert truth["Boxes3D:colors"][0][6] == truth["Boxes3D:colors"][0][1]
    yaw = 2.0 * np.arctan2(*np.array(truth["Boxes3D:quaternions"][0])[:, 2:].T)
    assert yaw[6] - yaw[1] == pytest.approx(0.5, abs=1e-5)
    assert 3.0 < np.linalg.norm(centers[6] - centers[1]) < 9.0 / 2
