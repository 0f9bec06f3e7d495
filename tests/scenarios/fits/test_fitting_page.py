"""The pictures of fits."""

import numpy as np
import pytest
from fits import pictures
from fits.case import case_of
from fits.simulated_cases import worst_cases
from support import short_run

from luxloop.scenarios.cli import main
from luxloop.scenarios.errors import OutputError
from luxloop.tracker.records import METHODS, Candidates


def test_a_case_is_in_the_frame_of_the_true_box():
    """A vehicle at (10, 5) with heading 90 degrees; its front is at (10, 7), its left side at x = 9."""
    heading = np.radians([[95.0, 88.0, 0.5, 90.0, np.nan]])[:, : len(METHODS)]
    count = heading.shape[1]
    candidates = Candidates(
        heading=heading,
        center_ego=np.tile([10.5, 5.0], (1, count, 1)),
        size=np.tile([4.0, 2.0], (1, count, 1)),
        cost=np.ones((1, count)),
        best=np.array([1]),
    )
    points, box = np.array([[10.0, 7.0], [9.0, 5.0]]), np.array([10.0, 5.0, np.pi / 2, 4.0, 2.0])
    case = case_of("x", points, np.array([0, -1]), candidates, 0, box)
    assert case.points == pytest.approx(np.array([[2.0, 0.0], [0.0, 1.0]]))
    assert case.sensor == pytest.approx(np.array([-5.0, 10.0]))
    assert case.center[0] == pytest.approx([0.0, -0.5])
    assert case.errors[:4] == pytest.approx([5.0, -2.0, 0.5, 0.0])
    assert case.worst == pytest.approx(2.0)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fitting")
    path = short_run.write(folder, short_run.TEXT)
    main(["run", str(path), "--record-scans", "--no-recording", "--out", str(folder / "run")])
    return folder / "run"


def test_the_worst_fits_of_a_run_are_drawn(recorded, tmp_path):
    from luxloop.scenarios.run import run_folder

    fits = run_folder.read(recorded).tables["fits"]
    best = fits[fits["best"]]
    cases = worst_cases(recorded)
    assert max(case.worst for case in cases) == pytest.approx(best["heading_error_deg"].abs().max())
    assert {len(case.points) for case in cases} <= set(best["points"])
    pictures.draw(cases, tmp_path / "cases.png")
    assert (tmp_path / "cases.png").stat().st_size > 5000


def test_a_run_without_scans_is_refused_in_one_line(recorded, tmp_path):
    copy = tmp_path / "run"
    copy.mkdir()
    (copy / "tables").mkdir()
    (copy / "result.json").write_bytes((recorded / "result.json").read_bytes())
    for table in (recorded / "tables").iterdir():
        (copy / "tables" / table.name).write_bytes(table.read_bytes())
    with pytest.raises(OutputError, match="run the scenario again with --record-scans"):
        worst_cases(copy)
