"""Intervals of HOTA, MOTA and IDF1: those of the scores without each vehicle."""

import numpy as np
import pytest
from support.frames import Body, Estimate, Scripted, follow, grade_run

from luxloop.scenarios.statistics.jackknife import SHARE, jackknife_interval

FRAMES = 8
CARS = [Body(i, 4.0 * i, 8.0, yaw=1.57) for i in range(4)]
HIT = {0: range(8), 1: range(5), 2: range(2, 8), 3: ()}
"""Frames in which a track of its own hits each car, exactly."""
FALSE = 3
"""Frames with a track on nothing."""


def of_pool(times):
    """HOTA, MOTA and IDF1 of the false tracks and the cars, each drawn a number of times.

    A car that is hit exactly in h of 8 frames adds h detections with association h / 8.
    """
    false, *cars = times
    hits = sum(k * len(HIT[car]) for car, k in enumerate(cars))
    vehicles, tracks = FRAMES * sum(cars), hits + false * FALSE
    if not vehicles:
        return None
    association = sum(k * len(HIT[car]) ** 2 / FRAMES for car, k in enumerate(cars))
    hota = (association / max(vehicles + tracks - hits, 1)) ** 0.5
    return hota, (2 * hits - tracks) / vehicles, 2 * hits / (vehicles + tracks)


def test_intervals_are_those_of_pools_without_a_vehicle():
    script = [
        [
            *(follow(car) for car in CARS if i in HIT[car.id]),
            *([Estimate(9, 0.0, -20.0)] if i < FALSE else []),
        ]
        for i in range(FRAMES)
    ]
    metrics = grade_run([CARS] * FRAMES, Scripted(script))[0]
    everyone, names = np.ones(5), ("track.hota", "track.mota", "track.idf1")
    value = of_pool(everyone.astype(int).tolist())
    assert [metrics[name].value for name in names] == pytest.approx(value)
    without = np.array([of_pool((everyone - row).astype(int).tolist()) for row in np.eye(5)]).T
    weight = np.array([FALSE, *(FRAMES + len(HIT[car]) for car in range(4))], float)  # frames and tracks of each
    for name, whole, rest in zip(names, value, without, strict=True):
        within = (-np.inf, 1.0) if name == "track.mota" else SHARE
        assert metrics[name].interval == pytest.approx(jackknife_interval(whole, rest, weight, within)), name


def test_one_vehicle_has_no_interval():
    metrics = grade_run([CARS[:1]] * FRAMES, Scripted([[follow(CARS[0])]] * FRAMES))[0]
    assert metrics["track.hota"].interval is None
    assert metrics["track.idf1"].interval is None
