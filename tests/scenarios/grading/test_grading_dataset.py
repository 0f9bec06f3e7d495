"""Data set summary, counted by hand."""

import pytest
from support.frames import Body, Scripted, grade_run

from luxloop.sensor_model.truth import View

SCENE = [
    [Body(0, 12.0, 4.0), Body(1, 20.0, -4.0, view=View.REAR), Body(2, 25.0, 9.0, points=9)],
    [Body(0, 12.0, 4.0, view=View.SIDE), Body(1, 60.0, -4.0)],
    [],
    [Body(0, 12.0, 4.0, view=View.NONE)],
]
"""Observations per frame: two, one (the other vehicle is out of range), none, one; nine points are too few."""


@pytest.fixture(scope="module")
def metrics():
    return grade_run(SCENE, Scripted([[]] * len(SCENE)))[0]


def test_observations_vehicles_and_frames(metrics):
    """Fails when ungraded vehicles count, or frames without traffic do not."""
    names = ("vehicles", "observations", "frames", "observations_per_vehicle", "observations_per_frame")
    assert [metrics[f"dataset.{name}"].value for name in names] == [2, 4, 4, 2.0, 1.0]
    assert metrics["dataset.observations"].unit == "count"


def test_views_are_counted_with_their_shares(metrics):
    found = {
        view: metrics[f"dataset.observations{{view={view}}}"].value
        for view in ("l_shape", "side", "rear", "front", "none")
    }
    assert found == {"l_shape": 1, "side": 1, "rear": 1, "front": 0, "none": 1}
    assert metrics["dataset.share{view=rear}"].value == 0.25
    assert metrics["dataset.share{view=front}"].value == 0.0


def test_run_without_vehicles_has_zero_counts_and_no_shares():
    metrics = grade_run([[]] * 3, Scripted([[]] * 3))[0]
    assert [metrics[f"dataset.{name}"].value for name in ("vehicles", "observations", "frames")] == [0, 0, 3]
    assert metrics["dataset.share{view=rear}"].value is metrics["dataset.observations_per_vehicle"].value is None
    assert metrics["dataset.share{view=rear}"].reason == "no vehicle was graded"
