"""Tables of real vehicles: reading, and one line for every mistake."""

import numpy as np
import pytest

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.realism.real_table import read, read_bands

TABLE = """\
class,range_m,aspect_deg,front_seen,bow_end_m,best_error_deg
car,12.5,30,True,0.2,1.5
van,8,75.5,False,,0.5
"""
BANDS = """\
face,from_m,to_m,lower_quartile_m,median_m,upper_quartile_m,vehicles
end,0.45,0.75,0.12,0.16,0.28,12
flank,0,0.45,0.05,0.07,0.12,7
"""


def write(tmp_path, text):
    path = tmp_path / "cars.csv"
    path.write_text(text)
    return path


def test_figures_and_views_are_read(tmp_path):
    real = read(write(tmp_path, TABLE))
    assert real["front_seen"].tolist() == [True, False]
    assert real["range_m"].tolist() == [12.5, 8.0]
    assert real["bow_end_m"][0] == 0.2
    assert np.isnan(real["bow_end_m"][1])
    assert "class" not in real


def test_bands_are_read(tmp_path):
    bands = read_bands(write(tmp_path, BANDS))
    assert bands["face"].tolist() == ["end", "flank"]
    assert bands.loc[0, ["from_m", "to_m", "median_m", "vehicles"]].tolist() == [0.45, 0.75, 0.16, 12.0]
    assert len(read_bands(None)) == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("aspect_deg", "aspect", "column aspect_deg is missing"),
        ("0.2", "wide", "column bow_end_m, row 1: 'wide'; give a number"),
        ("0.2", "inf", "column bow_end_m, row 1: 'inf'; give a number"),
        ("False", "rear", "column front_seen, row 2: 'rear'; give True or False"),
        ("12.5", "", "column range_m, row 1: ''; give a number"),
        ("12.5", "-3", "column range_m, row 1: '-3'; give a positive distance"),
        ("12.5", "12.5,3", "row 1: 7 cells, but the header has 6; give each row as many"),
        ("bow_end_m,best_error_deg", "width_m,colour", "has no figure to compare"),
        (TABLE[TABLE.index("car,") :], "", "has no rows"),
        (TABLE, "", "is not a CSV file"),
        ("van,", 'van,"', "is not a CSV file"),
    ],
)
def test_mistakes_name_file_column_row_and_remedy(tmp_path, old, new, message):
    path = write(tmp_path, TABLE.replace(old, new, 1))
    with pytest.raises(InputError) as error:
        read(path)
    assert str(error.value).startswith(f"{path}: {message}")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("end,", "front,", "column face, row 1: 'front'; give end or flank"),
        ("0.16", "", "column median_m, row 1: ''; give a number"),
        ("0.75", "0.40", "column to_m, row 1: '0.40'; give more than from_m"),
        ("vehicles", "cars", "column vehicles is missing"),
    ],
)
def test_mistakes_in_bands(tmp_path, old, new, message):
    path = write(tmp_path, BANDS.replace(old, new, 1))
    with pytest.raises(InputError) as error:
        read_bands(path)
    assert str(error.value).startswith(f"{path}: {message}")


def test_a_missing_file_or_a_folder_is_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        read(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is not a CSV file"):
        read(tmp_path)


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "cars.csv"
    path.write_bytes(bytes(range(128, 256)))
    with pytest.raises(InputError, match="is not a CSV file"):
        read(path)
