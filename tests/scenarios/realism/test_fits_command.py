"""`luxloop fits`: fits to labelled vehicles of recordings and data sets."""

import json

import numpy as np
import pandas as pd
import pytest
from support.labelled_shapes import SIZE, l_shape, left, rear, vehicle, write_data_set
from support.real_data import real_file

from luxloop.scenarios.cli import main
from luxloop.scenarios.realism import fit_observations, fit_report

POSE = (12.0, -12.0, 0.3)


def cloud(**columns):
    seen = vehicle(l_shape(), pose=POSE)
    x, y, z = seen.points_ego.T
    return pd.DataFrame({"frame": 0, "x_ego_m": x, "y_ego_m": y, "z_ego_m": z, **columns})


def write_recording(folder, turned_by=0.0):
    """Write two scans of a standing ego that is turned by 0.5 rad, with a car at POSE of the ego frame."""
    folder.mkdir()
    ego = np.array([100.0, 50.0, 0.5])
    cos, sin = np.cos(ego[2]), np.sin(ego[2])
    place = ego[:2] + np.array([cos * POSE[0] - sin * POSE[1], sin * POSE[0] + cos * POSE[1]])
    scans = {"time_s": [0.0, 0.1], "odom_x_m": ego[0], "odom_y_m": ego[1], "odom_yaw_rad": ego[2]}
    label = {"actor_id": 7, "kind": "car", "x_world_m": place[0], "y_world_m": place[1]}
    size = dict(zip(("length_m", "width_m", "height_m"), (*SIZE, 1.5), strict=True))
    still = dict.fromkeys(("vx_world_mps", "vy_world_mps", "yaw_rate_radps"), 0.0)
    pd.DataFrame({"frame": [0, 1], **scans}).to_parquet(folder / "scans.parquet")
    heading = {"heading_world_rad": POSE[2] + ego[2] + turned_by}
    pd.DataFrame([{"frame": n, **label, **heading, **size, **still} for n in (0, 1)]).to_parquet(
        folder / "labels.parquet"
    )
    points = pd.concat([cloud(time_offset_s=0.0, layer=np.uint8(0)).assign(frame=n) for n in (0, 1)])
    points.to_parquet(folder / "bumper_points.parquet")
    points[points["frame"] == 0].to_parquet(folder / "roof_points.parquet")
    return folder


def test_a_recording_gives_the_vehicles_of_each_cut_in_the_ego_frame(tmp_path):
    folder = write_recording(tmp_path / "street")
    cuts = fit_observations.cuts(folder)
    found = [fit_observations.read(folder, points, 3) for points in cuts]
    assert [path.name for path in cuts] == ["bumper_points.parquet", "roof_points.parquet"]
    assert [[(one.data_set, one.actor_id, one.frame) for one in each] for each in found] == [
        [(3, 7, 0), (3, 7, 1)],
        [(3, 7, 0)],
    ]
    np.testing.assert_allclose(found[0][1].box, [*POSE, *SIZE])
    np.testing.assert_allclose(found[0][1].points_box, l_shape(), atol=1e-9)


def test_errors_of_a_turned_label(tmp_path):
    folder = write_recording(tmp_path / "street", turned_by=np.radians(4.0))
    groups = fit_observations.of_folders([folder])
    assert list(groups) == ["street bumper", "street roof"]
    rows = groups["street bumper"]
    for method in ("closeness", "tlinkage", "alignment", "best"):
        assert rows[method].to_numpy() == pytest.approx(4.0, abs=0.3), method
    assert (rows["oracle"] == rows[[*fit_report.COMPARED, "best"]].min(axis=1)).all()
    assert rows["vehicle"].nunique() == 1
    assert set(rows["view"]) == {"flank over 2.5 m"}
    assert set(rows["range"]) == {"15 to 30 m"}


def test_all_data_sets_are_one_group_beside_the_cuts(tmp_path, capsys):
    label = {"x_ego_m": POSE[0], "y_ego_m": POSE[1], "heading_ego_rad": POSE[2]}
    sets = [write_data_set(tmp_path / name, cloud(), [label]) for name in ("one", "two")]
    assert main(["fits", str(write_recording(tmp_path / "street")), *map(str, sets), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["sources"]
    assert list(found) == ["street bumper", "street roof", "simulated"]
    assert (found["simulated"]["clusters"], found["simulated"]["vehicles"]) == (2, 2)
    assert found["simulated"]["error_deg"]["best"][0] < 0.5
    assert main(["fits", str(sets[0])]) == 0
    assert "flank over 2.5 m" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("points", "height", "lidar", "expected"),
    [
        (left(0.0, np.linspace(-1.5, 1.5, 20)), 0.5, (0.0, 20.0), 0),
        (
            np.concatenate([rear(0.0, np.linspace(-0.8, 0.8, 20)), left(0.0, np.linspace(-2.1, -0.9, 9))]),
            0.5,
            (-12, 12),
            1,
        ),
        (rear(0.0, np.linspace(-0.8, 0.8, 20)), 0.5, (-20.0, 0.0), 2),
        (left(0.0, np.linspace(-1.5, 1.5, 20)), 1.2, (0.0, 20.0), 3),
    ],
)
def test_kinds_of_view(points, height, lidar, expected):
    assert fit_observations.view(vehicle(points, height=height, lidars=[lidar])) == fit_observations.VIEWS[expected]


def test_coverage_counts_deviations_inside_the_central_interval():
    rows = pd.DataFrame({"deviation": [0.5, 0.7, 1.7, np.nan], "vehicle": np.arange(4)})
    assert fit_report.covered(rows, 50)[0] == pytest.approx(100 / 3)
    assert fit_report.covered(rows, 90)[0] == pytest.approx(200 / 3)
    assert fit_report.covered(rows, 99)[0] == pytest.approx(100)


def test_means_per_cluster_and_per_vehicle_differ_by_the_number_of_frames():
    rows = pd.DataFrame({"best": [1.0, 1.0, 4.0], "vehicle": [0, 0, 1]})
    assert fit_report.mean(rows, rows["best"])[0] == pytest.approx(2.0)
    assert fit_report.mean_by_vehicle(rows, rows["best"])[0] == pytest.approx(2.5)


@pytest.mark.parametrize("name", ["scans", "labels"])
def test_a_damaged_recording_is_refused(tmp_path, name, capsys):
    folder = write_recording(tmp_path / "street")
    table = pd.read_parquet(folder / f"{name}.parquet")
    table.drop(columns=table.columns[1]).to_parquet(folder / f"{name}.parquet")
    assert main(["fits", str(folder)]) == 2
    assert f"{name}.parquet: has no column" in capsys.readouterr().err


@pytest.mark.slow
def test_a_street_of_real_cars():
    """The alignment errs less than the single criteria on both cuts of a real drive."""
    groups = fit_observations.of_folders([real_file("street/labels.parquet").parent])
    for rows in groups.values():
        assert len(rows) > 900
        for method in ("area", "closeness", "variance", "tlinkage"):
            assert rows["alignment"].mean() < rows[method].mean(), method
