"""Use of the random streams: each counter of a run serves one draw of one purpose, and streams are independent."""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from support.independence import dependence
from support.noise_scenes import BEAMS
from support.sensor_scenes import ActorSpec, small_unit, walls, world

from luxloop.sensor_model.kernels import clusters, noise
from luxloop.sensor_model.kernels.philox import philox
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise import dropout, false_alarms, outage, precipitation, random_draws, spray
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.sensor_model.sensor_config import SensorConfig

USERS = {
    random_draws: ("beam_pairs", "counter_pairs"),
    dropout: ("soft_thresholds",),
    false_alarms: ("rare_beams",),
    precipitation: ("rare_beams",),
    spray: ("cluster_echoes",),
    outage.kernels: ("silent_units", "_uniform"),
    clusters: ("_chord", "_beams_near"),
}
"""Kernels that draw, by the module that calls them."""

AGAIN = {Purpose.OUTAGE, Purpose.SPRAY_BIRTH, Purpose.SPRAY_PLACE, Purpose.SPRAY_HEIGHT, Purpose.SPRAY_RADIUS}
"""Purposes without state between frames: each frame draws their past again."""

RIG = Rig(
    0.0,
    (
        Mount("left", small_unit(), 2.2, 0.8, 0.6, 25.0, 0.0, 0.0),
        Mount("right", small_unit(), 2.2, -0.8, 0.6, -25.0, 0.0, 0.0),
    ),
)
FACADE = walls(((-40, 9), (40, 9)), ((40, 40), (40, -40)), height=6.0, reflectivity=0.9)


def all_noise():
    """Return all kinds of noise, at strengths with which each of them draws in every frame."""
    config = NoiseConfig()
    config = replace(config, **{kind: replace(getattr(config, kind), enabled=True) for kind in KINDS})
    return replace(
        config,
        outliers=replace(config.outliers, rate=0.2),
        false_alarms=replace(config.false_alarms, rate=0.2),
        rain=replace(config.rain, rate_mm_per_h=100.0, drops_per_mm_per_h=2e-3),
        spray=replace(config.spray, echo_share=1.0),
        fog=replace(config.fog, visibility_m=50.0),
        outage=replace(config.outage, mean_uptime_s=1e9),
    )


@pytest.fixture
def drawn(monkeypatch):
    """Return the list of all counters that the kernels give to Philox from now on, with their keys."""
    found = []

    def record(c0, c1, c2, c3, k0, k1):
        found.append(tuple(map(int, (c0, c1, c2, c3, k0, k1))))
        return philox(c0, c1, c2, c3, k0, k1)

    for module, names in USERS.items():
        for name in names:
            monkeypatch.setattr(module, name, getattr(module, name).py_func)
    monkeypatch.setattr(noise, "philox", record)
    monkeypatch.setattr(clusters, "philox", record)
    return found


def test_no_counter_of_a_run_serves_two_draws(drawn):
    """Fails if a purpose is used twice, or if numbers of beams, places, ticks or clusters run into one another."""
    speeds = ((25.0, 0.0), (30.0, 0.0))
    cars = [ActorSpec(12.0 + 2.0 * frame, 1.0, velocity=speeds[0], yaw_rate=0.2) for frame in range(4)]
    others = [ActorSpec(20.0 + 2.4 * frame, -3.0, velocity=speeds[1]) for frame in range(4)]
    lidar = Lidar(RIG, all_noise(), SensorConfig((1, 1)), 7, FACADE)
    of_run, of_frames = Counter(drawn), []
    for index, actors in enumerate(zip(cars, others, strict=True)):
        drawn.clear()
        lidar.scan(world(*actors, ego=ActorSpec(2.0 * index, 0.0, velocity=(25.0, 0.0), yaw_rate=0.1), index=index))
        of_frames.append(Counter(drawn))
    for counters in (of_run, *of_frames):
        assert [counter for counter, times in counters.items() if times > 1] == []
    total = of_run + sum(of_frames, Counter())
    twice = {counter[3] for counter, times in total.items() if times > 1}
    assert twice <= {int(purpose) for purpose in AGAIN}
    used = {c3 % 256 for _, c1, _, c3, *_ in total if c1 >> 8 != Purpose.SPRAY_ECHO}
    used |= {Purpose.SPRAY_ECHO for _, c1, *_ in total if c1 >> 8 == Purpose.SPRAY_ECHO}
    assert used == set(Purpose), "every purpose draws in this scene"
    assert {counter[4:] for counter in total} == {(7, 0)}


@pytest.mark.parametrize("purpose", [Purpose.SPRAY_PLACE, Purpose.RANGE])
def test_two_draws_of_one_counter_and_draws_of_two_purposes_are_independent(purpose):
    number = np.arange(4000)
    draws = Draws(3, BEAMS)
    series = [*draws.uniform_of(1, number, 0, purpose), *draws.uniform_of(1, number, 0, Purpose.SPRAY_RADIUS)]
    assert min(dependence(one, other) for one, other in combinations(series, 2)) > 1e-3
