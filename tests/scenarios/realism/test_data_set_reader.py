"""Vehicles of data sets written by hand."""

import numpy as np
import pandas as pd
import pytest
from support.labelled_shapes import write_data_set

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism.labelled_vehicle import read

GRID = np.array([(x, y) for x in np.linspace(-2.0, 2.0, 5) for y in np.linspace(-0.8, 0.8, 5)])
"""Points inside a box about the origin [m]."""
AHEAD = GRID + np.array((10.0, 0.0))


def cloud(points, z=0.5, **columns):
    points = np.asarray(points, np.float64)
    place = dict(zip(("x_ego_m", "y_ego_m", "z_ego_m"), (*points.T, np.full(len(points), z)), strict=True))
    return pd.DataFrame({**place, **columns})


def only(folder, sigma_deg=0.0):
    (vehicle,) = read(folder, 0, sigma_deg, 0)
    return vehicle


def test_points_of_a_vehicle_are_in_its_grown_box(tmp_path):
    """Half a length is 2.2 m and half a width 0.9 m, and 15 cm more; heights are from 15 cm to the top + 20 cm."""
    near = [(10 + 2.34, 0.0), (10 - 2.36, 0.0), (10.0, 1.04), (10.0, 1.06)]
    points = pd.concat([cloud(AHEAD), cloud(near), cloud([(10.0, 0.0)], 0.14), cloud([(10.0, 0.0)], 1.69)])
    points = pd.concat([points, cloud([(10.0, 0.0)], 1.71)])
    seen = only(write_data_set(tmp_path / "set", points, [{"x_ego_m": 10.0}]))
    expected = np.vstack([np.column_stack([AHEAD, np.full(25, 0.5)]), (12.34, 0, 0.5), (10, 1.04, 0.5)])
    np.testing.assert_allclose(seen.points_ego, np.vstack([expected, (10, 0, 1.69)]))
    assert (seen.kind, seen.actor_id, seen.frame) == ("car", 1, 0)


@pytest.mark.parametrize(
    ("label", "count"),
    [
        ({}, 1),
        ({"graded": False}, 0),
        ({"x_ego_m": 13.36}, 0),  # the box starts at 11.01 and holds nine of the points
        ({"x_ego_m": 13.26}, 1),  # ten
    ],
)
def test_graded_vehicles_with_ten_points_count(tmp_path, label, count):
    points = cloud(np.column_stack([np.linspace(10.0, 11.9, 20), np.zeros(20)]))
    folder = write_data_set(tmp_path / "set", points, [{"x_ego_m": 10.0, **label}])
    assert len(read(folder, 0, 0.0, 0)) == count


def test_motion_between_point_and_frame_is_undone(tmp_path):
    """The ego turns and drives, the car drives and turns; each point is measured at its own time, as a LIDAR does."""
    after = np.linspace(-0.04, 0.04, len(GRID))
    ego_yaw, ego_rate, ego_velocity = 0.7, 0.3, np.array([6.0, 8.0])
    car, car_yaw, car_velocity, car_rate = np.array([9.0, -5.0]), 2.0, np.array([-3.0, 4.0]), -0.5

    def turned(vectors, angle):
        cos, sin, x, y = np.cos(angle), np.sin(angle), vectors[..., 0], vectors[..., 1]
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)

    world = car + car_velocity * after[:, None] + turned(GRID, car_yaw + car_rate * after)
    measured = turned(world - ego_velocity * after[:, None], -(ego_yaw + ego_rate * after))
    place = turned(car, -ego_yaw)
    label = {
        "x_ego_m": place[0], "y_ego_m": place[1], "heading_ego_rad": car_yaw - ego_yaw, "vx_world_mps": car_velocity[0],
        "vy_world_mps": car_velocity[1], "yaw_rate_radps": car_rate,
    }  # fmt: skip
    ego = {
        "ego_yaw_world_rad": ego_yaw, "ego_vx_world_mps": 6.0, "ego_vy_world_mps": 8.0, "ego_yaw_rate_radps": ego_rate
    }  # fmt: skip
    seen = only(write_data_set(tmp_path / "set", cloud(measured, time_offset_s=after), [label], ego))
    np.testing.assert_allclose(seen.points_box, GRID, atol=1e-9)


def test_lidars_are_those_with_points_on_the_vehicle_most_first(tmp_path):
    lidars = [{"x_ego_m": x, "y_ego_m": y} for x, y in [(3.5, 0.7), (-1.0, 0.9), (3.5, -0.7)]]
    points = cloud(AHEAD, unit=[2] * 15 + [0] * 10, layer=[1] * 15 + [3] * 10)
    seen = only(write_data_set(tmp_path / "set", points, [{"x_ego_m": 10.0}], lidars=lidars))
    np.testing.assert_allclose(seen.lidars, [(3.5, -0.7), (3.5, 0.7)])
    assert seen.range_m == pytest.approx(np.hypot(6.5, 0.7))
    assert np.unique(seen.line).tolist() == [3, 2 * 256 + 1]


def test_an_earlier_data_set_without_lidars_is_seen_from_the_ego(tmp_path):
    seen = only(write_data_set(tmp_path / "set", cloud(AHEAD), [{"x_ego_m": 10.0}]))
    np.testing.assert_allclose(seen.lidars, [(0.0, 0.0)])


def test_label_errors_are_normal_and_keyed_by_seed_and_data_set(tmp_path):
    labels = [{"x_ego_m": 10.0 + 6.0 * n, "actor_id": n, "frame": frame} for frame in range(20) for n in range(20)]
    rows = np.concatenate([AHEAD + np.array((6.0 * n, 0.0)) for n in range(20)])
    points = pd.concat([cloud(rows, frame=frame) for frame in range(20)])
    folder = write_data_set(tmp_path / "set", points, labels)

    def errors(number, seed, sigma_deg=1.5):
        return np.array([np.degrees(seen.box[2]) for seen in read(folder, number, sigma_deg, seed)])

    first = errors(0, 7)
    assert np.std(first) == pytest.approx(1.5, rel=0.12)  # a deviation of 400 values is known to 3.5 %
    assert abs(np.mean(first)) < 0.25
    np.testing.assert_array_equal(first, errors(0, 7))
    assert (first != errors(0, 8)).all()
    assert (first != errors(1, 7)).all()
    np.testing.assert_array_equal(errors(0, 7, 0.0), 0.0)


def test_a_vehicle_about_the_lidar_shows_no_face(tmp_path):
    assert read(write_data_set(tmp_path / "set", cloud(GRID), [{}]), 0, 0.0, 0) == []


@pytest.mark.parametrize("name", ["scans", "points", "labels"])
def test_files_of_other_programs_are_refused(tmp_path, name):
    folder = write_data_set(tmp_path / "set", cloud(AHEAD), [{"x_ego_m": 10.0}])
    path = folder / f"{name}.parquet"
    pd.DataFrame({"frame": [0]}).to_parquet(path)
    with pytest.raises(InputError, match=rf"{name}\.parquet: cannot be read .*--dataset"):
        read(folder, 0, 0.0, 0)
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(InputError, match=rf"{name}\.parquet: cannot be read"):
        read(folder, 0, 0.0, 0)
    path.unlink()
    with pytest.raises(InputError, match=rf"has no {name}\.parquet; name a folder"):
        read(folder, 0, 0.0, 0)


@pytest.mark.parametrize("text", ["", "[]", '{"lidars": [{"x_ego_m": 1}]}', '{"lidars": 3}'])
def test_a_broken_summary_is_refused(tmp_path, text):
    folder = write_data_set(tmp_path / "set", cloud(AHEAD), [{"x_ego_m": 10.0}])
    (folder / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"summary\.json: cannot be read"):
        read(folder, 0, 0.0, 0)
