"""`paper-campus`: agreement with table I of the paper, without tracker."""

from contextlib import closing

import pandas as pd
import pytest

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import paths
from luxloop.scenarios.grading.frame_truth import FrameTruth
from luxloop.scenarios.report.paper_comparison import DATASET, PAPER_VIEWS
from luxloop.scenarios.run import loop
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import View
from luxloop.sim.world import Kind, Mode

pytestmark = pytest.mark.slow

EVERY = 5
"""Stride of scanned frames: vehicles are visible for seven seconds, and neighbouring frames are similar."""


@pytest.fixture(scope="module")
def observations():
    """Return a row for each graded vehicle in each scanned frame of the run."""
    scenario = Scenario.load(paths()["paper-campus"])
    rig = load_rig(str(scenario.rig), scenario.folder)
    tables = []
    with closing(loop._traffic(scenario, rig)) as source:
        lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
        assert round(scenario.duration_s / source.dt) == DATASET["frames"]
        for index in range(DATASET["frames"]):
            frame = source.step()
            if index % EVERY == 0:
                scan, truth = lidar.scan(frame)
                now, actors = FrameTruth.of(frame, scan, truth, scenario.grading), frame.actors
                table = {"name": actors.name, "kind": actors.kind, "mode": actors.mode, "view": truth.view}
                tables.append(pd.DataFrame(table)[now.graded])
    return pd.concat(tables)


def test_numbers_of_vehicles_and_observations(observations):
    assert observations["name"].nunique() == pytest.approx(DATASET["vehicles"], rel=0.2)
    assert EVERY * len(observations) == pytest.approx(DATASET["observations"], rel=0.2)


def test_shares_of_visible_sides(observations):
    # A side counts if it has three points. Only the side of a passing car is visible for the few frames abreast,
    # which gives more sides than in the paper, as any passing traffic does. Far ends in dark paint have fewer points.
    shares = observations["view"].value_counts(normalize=True)
    theirs = {view: count / DATASET["observations"] for view, count in PAPER_VIEWS.items()}
    assert shares[View.L_SHAPE] == pytest.approx(theirs["l_shape"], abs=0.18)
    assert shares[View.SIDE] == pytest.approx(theirs["side"], abs=0.15)
    assert shares[View.REAR] == pytest.approx(theirs["rear"], abs=0.02)
    assert shares[View.FRONT] < 0.03


def test_standing_and_moving_cars_occur(observations):
    assert set(observations["kind"]) <= {Kind.CAR, Kind.SUV, Kind.VAN}
    modes = observations["mode"].value_counts(normalize=True)
    assert all(modes[mode] > 0.2 for mode in Mode)
    by_vehicle = observations.groupby("name")["mode"]
    parked = by_vehicle.apply(lambda modes: (modes == Mode.STATIONARY).all())
    assert 5 <= parked.sum() <= 15
