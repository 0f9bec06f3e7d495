"""Recordings in CSV and Parquet: the layout, and errors of one line."""

import gzip

import numpy as np
import pandas as pd
import pytest

from luxloop.sim.replay.recording import ReplayType
from luxloop.sim.replay.track_tables import read_table
from luxloop.sim.scripted.script import SIZE_BY_KIND
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

FULL = """\
time_s,id,x_m,y_m,yaw_deg,length_m,width_m,height_m,kind,reflectivity,lane
0.0,7,1.0,2.0,90.0,4.2,1.7,1.4,car,0.5,a
0.1,007,3.0,2.0,180.0,,,,trailer-truck,,b
0.1,7,1.0,3.0,90.0,4.4,1.7,1.4,car,0.5,a
0.2,7,1.0,4.0,90.0,4.2,1.7,1.4,car,0.5,a
"""


@pytest.fixture
def csv(tmp_path):
    def write(text, name="a.csv"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def test_all_columns_are_read(csv):
    read = read_table(csv(FULL), {})
    lorry, car = read.users  # ordered by id, which remains text
    assert (lorry.name, lorry.kind, lorry.size, lorry.reflectivity) == (
        "007",
        Kind.TRAILER_TRUCK,
        SIZE_BY_KIND[Kind.TRAILER_TRUCK],
        None,
    )
    assert (car.name, car.kind, car.size, car.reflectivity) == ("7", Kind.CAR, (4.2, 1.7, 1.4), 0.5)
    assert list(read.user) == [1, 0, 1, 1]
    assert read.time == pytest.approx([0.0, 0.1, 0.1, 0.2])
    assert read.pose == pytest.approx(
        np.array([[1, 2, np.pi / 2], [3, 2, np.pi], [1, 3, np.pi / 2], [1, 4, np.pi / 2]])
    )


def test_four_columns_are_sufficient(csv):
    read = read_table(csv("y_m, time_s, x_m, id\n2, 0, 1, a\n2, 1, 2, a\n"), {})
    (user,) = read.users
    assert (user.name, user.kind, user.size) == ("a", Kind.CAR, SIZE_BY_KIND[Kind.CAR])
    assert read.pose[:, :2] == pytest.approx(np.array([[1, 2], [2, 2]]))
    assert np.isnan(read.pose[:, 2]).all()


def test_custom_names_of_kinds_can_be_mapped(csv):
    text = "time_s,id,x_m,y_m,kind\n0,1,0,0,truck_bus\n0,2,9,0,\n"
    types = {"truck_bus": ReplayType("truck", (9.0, 2.5, 3.0)), "car": ReplayType("suv")}
    lorry, other = read_table(csv(text), types).users
    assert (lorry.kind, lorry.size) == (Kind.TRUCK, (9.0, 2.5, 3.0))
    assert (other.kind, other.size) == (Kind.SUV, SIZE_BY_KIND[Kind.SUV])


def test_compressed_and_parquet_files_give_the_same_result(csv, tmp_path):
    path = csv(FULL)
    plain = read_table(path, {})
    (tmp_path / "b.csv.gz").write_bytes(gzip.compress(FULL.encode()))
    pd.read_csv(path, dtype={"id": str}).to_parquet(tmp_path / "c.parquet")
    for name in ("b.csv.gz", "c.parquet"):
        other = read_table(tmp_path / name, {})
        assert other.users == plain.users
        assert np.array_equal(other.user, plain.user)
        assert np.array_equal(other.pose, plain.pose)
        assert np.array_equal(other.time, plain.time)


@pytest.mark.parametrize("ids", [[7, 12], [7.0, 12.0], ["7", "12"]])
def test_ids_in_parquet_may_be_numbers(tmp_path, ids):
    frame = pd.DataFrame({"time_s": [0, 0], "id": ids, "x_m": [0.0, 9.0], "y_m": np.float32([0, 0])})
    frame.to_parquet(tmp_path / "a.parquet")
    assert {user.name for user in read_table(tmp_path / "a.parquet", {}).users} == {"7", "12"}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.1,7,1.0,3.0", "0.1,7,nan,3.0", "column x_m, row 3: nan: should be a number"),
        ("0.1,7,1.0,3.0", "0.1,7,inf,3.0", "column x_m, row 3: inf: should be a number"),
        ("0.1,7,1.0,3.0", "0.1,7,,3.0", "column x_m, row 3: an empty cell: should be a number"),
        ("0.1,7,1.0,3.0", "soon,7,1.0,3.0", "column time_s, row 3: soon: should be a number"),
        ("3.0,90.0", "3.0,", "column yaw_deg, row 3: an empty cell"),
        ("0.1,7,", "0.1,,", "column id, row 3: an empty cell"),
        ("4.4", "-4.4", "column length_m, row 3: -4.4: should be positive"),
        ("4.4", "0", "column length_m, row 3: 0.0: should be positive"),
        ("1.4,car,0.5,a\n0.2", "1.4,car,1.5,a\n0.2", "column reflectivity, row 3: 1.5: should be at most 1"),
        (
            "trailer-truck",
            "lorry",
            'column kind, row 2: type "lorry" is neither in traffic.types nor a kind',
        ),
        ("1.4,car,0.5,a\n0.2", "1.4,bus,0.5,a\n0.2", "column kind, row 3: bus: differs from an earlier row"),
        ("x_m,y_m", "x,y", "column x_m is missing; the file has time_s, id, x, y, yaw_deg"),
        ("0.1,007,3.0,", "0.1,007,3.0,9.0,9.0,", "not a table: Error tokenizing data."),
        (FULL, "", "not a table: No columns to parse from file"),
        (FULL.partition("\n")[2], "", "has no rows"),
    ],
)
def test_invalid_tables_are_errors_of_one_line(csv, old, new, message):
    assert FULL.count(old) == 1
    with pytest.raises(TrafficInputError) as error:
        read_table(csv(FULL.replace(old, new)), {})
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_row_of_more_cells_than_the_header_is_not_read_shifted(csv):
    """pandas would take `time_s` for the index: a car at time 7, named 0."""
    with pytest.raises(TrafficInputError, match=r"^row 1: 6 cells, but the header has 4; give each row as many"):
        read_table(csv("time_s,id,x_m,y_m\n0,7,0,1,2,3\n0,7,0,1,2,3\n"), {})


@pytest.mark.parametrize("name", ["a.csv", "a.csv.gz", "a.parquet"])
def test_a_file_that_is_not_a_table_is_an_error(tmp_path, name):
    (tmp_path / name).write_bytes(b"\xff\xfe\x00PAR1 nonsense")
    with pytest.raises(TrafficInputError, match=r"^not a table: [^\n]+$"):
        read_table(tmp_path / name, {})


def test_dates_are_rejected_as_times(tmp_path):
    frame = pd.DataFrame({"time_s": pd.to_datetime(["2024-01-01"]), "id": ["a"], "x_m": [0.0], "y_m": [0.0]})
    frame.to_parquet(tmp_path / "a.parquet")
    with pytest.raises(TrafficInputError, match=r"column time_s holds datetime64\[\w+\]; write numbers"):
        read_table(tmp_path / "a.parquet", {})
