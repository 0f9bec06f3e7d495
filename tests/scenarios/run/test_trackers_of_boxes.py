"""Trackers that only report boxes: the nearest-neighbour example, and expectations on outputs that they leave out."""

import json

import pytest
from support import short_run
from support.frames import Body, drive, grade_run
from support.paths import DOCS, EXAMPLES

from luxloop.scenarios.cli import main
from luxloop.scenarios.files.expect import Check, Limit, check, verdict
from luxloop.scenarios.result import NOT_REPORTED, Metric
from luxloop.tracker.records import Tracks

NEAREST = EXAMPLES / "ci" / "my_tracker.py"
EXPECT = """
[expect]
"track.hota" = { min = 0.01 }
"track.missed" = { max = 200 }
"fit.heading_abs_mean_deg" = { max = 5.0 }
"mma.mode_accuracy" = { min = 0.5 }
"mma.x_abs_mean_m{model=ca,target=moving}" = { max = 1.0 }
"mma.nees_in_band" = { min = 0.5 }
"track.acceleration_abs_mean_mps2" = { max = 1.0 }
"mma.switch_latency_frames" = { max = 20, known_failure = "the shipped tracker's own" }
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    short_run.write(tmp_path, short_run.TEXT + EXPECT)
    return tmp_path


def test_the_page_quotes_the_example_which_has_forty_lines():
    text = NEAREST.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 40
    assert f"```python\n{text}```" in (DOCS / "own-tracker.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_example_fails_nothing_that_it_does_not_report(folder, capfd):
    command = ["run", "short.toml", "--tracker", f"{NEAREST}:Nearest", "--out", "ran"]
    assert main([*command, "--json"]) == 0
    document = json.loads(capfd.readouterr().out)
    assert document["verdict"] == "passed"
    assert document["failed"] == document["known_failures"] == []
    assert len(document["not_applicable"]) == 6
    for name in document["not_applicable"]:
        metric = document["metrics"][name]
        assert metric["value"] is None
        assert metric["reason"].startswith(NOT_REPORTED)
    assert document["metrics"]["track.velocity_abs_mean_mps"]["value"] is not None
    assert document["metrics"]["mma.stationary_accuracy"]["value"] is not None
    assert main(["report", "ran"]) == 0
    assert "2 of 8 expectations hold, 6 not applicable" in (folder / "ran.html").read_text(encoding="utf-8")


class Boxes:
    """Reports the bodies of a scene with given speeds, which are not those of the bodies."""

    def __init__(self, scene, speeds, shift=0.0):
        self.left, self.speeds, self.shift = iter(scene), speeds, shift

    def step(self, _):
        bodies = next(self.left)
        velocity = None if self.speeds is None else [[speed, 0.0] for speed in self.speeds]
        centers = [[body.x + self.shift, body.y] for body in bodies]
        return Tracks.from_boxes(
            [body.id for body in bodies], centers, [body.yaw for body in bodies], bodies[0].size[:2], velocity
        )


def scene():
    """Return four frames of a standing and of a moving car."""
    return [[Body(0, 12.0, 4.0), Body(1, *drive(12.0, -4.0, 0.0, 5.0, i), 0.0, 5.0)] for i in range(4)]


@pytest.mark.parametrize(("speeds", "right"), [((0.2, 5.0), 1.0), ((0.2, 0.3), 0.5), ((2.0, 0.3), 0.0)])
def test_without_models_standing_is_judged_by_velocity(speeds, right):
    metrics = grade_run(scene(), Boxes(scene(), speeds))[0]
    assert metrics["mma.stationary_accuracy"].value == right
    assert metrics["mma.mode_accuracy"].not_reported


def test_without_models_and_velocity_nothing_is_said_about_motion():
    metrics = grade_run(scene(), Boxes(scene(), None))[0]
    assert metrics["track.hota"].value == pytest.approx(1.0)
    for name in ("mma.stationary_accuracy", "mma.mode_accuracy", "mma.nees_in_band", "track.velocity_abs_mean_mps"):
        assert metrics[name].not_reported, name


def test_the_position_of_a_box_is_judged_by_its_nearest_corner():
    """All boxes are 0.25 m too far along x, with the right size and heading, so their corners are, too."""
    metrics = grade_run(scene(), Boxes(scene(), None, shift=0.25))[0]
    assert metrics["mma.x_abs_mean_m{target=moving}"].value == pytest.approx(0.25)
    assert metrics["mma.y_abs_mean_m{target=moving}"].value == pytest.approx(0.0, abs=1e-9)


def test_an_output_that_is_left_out_is_not_applicable_and_nothing_tested_is_no_pass():
    left_out = Metric(None, "1", 0, f"{NOT_REPORTED} a covariance")
    no_data = Metric(None, "1", 0, "no confirmed track followed a graded vehicle")
    limit = Limit(min=0.5)
    outcomes = [Check("a", limit, metric).outcome for metric in (left_out, no_data, Metric(0.7, "1", 9))]
    assert outcomes == ["not applicable", "failed", "passed"]
    metrics = {"mma.nees_in_band": left_out, "track.hota": Metric(0.7, "1", 9)}
    assert verdict(check(metrics, {"mma.nees_in_band": limit, "track.hota": limit}), complete=True) == "passed"
    assert verdict(check(metrics, {"mma.nees_in_band": limit}), complete=True) == "failed"
