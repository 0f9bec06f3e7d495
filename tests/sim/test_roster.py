"""Numbers and paint of road users."""

import numpy as np
import pytest

from luxloop.sim.actor_draws import CAR_SHADES, SHADES, paint_reflectivity
from luxloop.sim.roster import Roster
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

SIZE = (4.7, 1.8, 1.5)


def test_numbers_follow_appearance_and_are_stable():
    roster = Roster(seed=1)
    assert roster.find("b") is None
    assert [roster.add(key, Kind.CAR, SIZE).id for key in ("b", "a")] == [0, 1]
    assert roster.find("b").id == 0
    assert roster.find("a").name == "car.1"


def test_paint_depends_only_on_seed_and_name():
    single = Roster(seed=3).add("x", Kind.CAR, SIZE, "taxi")
    crowded = Roster(seed=3)
    assert crowded.add("a", Kind.CAR, SIZE, "hearse").reflectivity != single.reflectivity
    assert crowded.add("y", Kind.SUV, SIZE, "taxi").reflectivity == single.reflectivity
    assert crowded.add("z", Kind.CAR, SIZE, "white", reflectivity=0.9).reflectivity == 0.9
    assert paint_reflectivity(4, "taxi", Kind.CAR) != single.reflectivity


@pytest.mark.parametrize(("kind", "shades"), [(Kind.CAR, CAR_SHADES), (Kind.VAN, CAR_SHADES), (Kind.BUS, SHADES)])
def test_paint_follows_the_shares_of_the_shades(kind, shades):
    draws = np.array([paint_reflectivity(11, f"car.{number}", kind) for number in range(2000)])
    assert sum(share for share, _, _ in shades) == pytest.approx(1.0)
    for share, low, high in shades:
        # four standard deviations of a binomial share
        assert np.mean((draws >= low) & (draws <= high)) == pytest.approx(share, abs=4 * (share / 2000) ** 0.5)


def test_paint_of_cars_has_the_measured_quartiles():
    draws = [paint_reflectivity(11, f"car.{number}", Kind.CAR) for number in range(2000)]
    assert np.quantile(draws, (0.25, 0.5, 0.75)) == pytest.approx([0.03, 0.075, 0.15], rel=0.15)


@pytest.mark.parametrize("size", [(np.inf, 1.8, 1.5), (np.nan, 1.8, 1.5), (4.7, 0.0, 1.5), (3e8, 2.5, 3.6)])
def test_a_size_that_no_body_has_is_one_line(size):
    """A bus of 3e8 m in an OpenSCENARIO file took 9 GB, and SUMO accepts types of infinite length."""
    with pytest.raises(TrafficInputError, match=r"^bus is .* m large; each side should be above 0 and at most 1000 m$"):
        Roster(0).add("key", Kind.BUS, size, "bus")
