"""Draws of a road user: paint, size, start and body come from streams of their own, which are independent."""

from collections import Counter
from itertools import combinations
from pathlib import Path

import numpy as np
from support.independence import dependence
from support.sensor_scenes import ActorSpec, world

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sim.actor_draws import Stream, actor_rng
from luxloop.sim.roster import Roster
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.world import Kind

SUMO_CAR = (5.0, 1.8, 1.5)
"""[m] A default size, which is redrawn."""


def test_no_stream_of_a_run_serves_two_draws(monkeypatch):
    made, philox = [], np.random.Philox

    def record(*, key, counter):
        made.append((*map(int, key), *map(int, counter)))
        return philox(key=key, counter=counter)

    monkeypatch.setattr(np.random, "Philox", record)
    roster = Roster(7, redraw_default_sizes=True)
    for name in ("own car", "first", "second"):
        roster.add(name, Kind.CAR, SUMO_CAR, name)
    actor = [ScriptedActor(x_m=10.0, y_m=0.0, name=name) for name in ("third", "fourth")]
    ScriptedSource(ScriptedTraffic("scripted", ScriptedEgo(), actor, jitter_m=1.0), Path(), 100.0).reset(7)
    bodies = BodyFactory(mirrors=True, plain=False, glass=Glass(), seed=7)
    bodies.place(world(ActorSpec(10.0, 0.0, id=1), ActorSpec(20.0, 0.0, id=2)))
    assert {counter[-1] for counter in made} == set(Stream)
    assert [counter for counter, times in Counter(made).items() if times > 1] == []


def test_draws_of_one_road_user_are_independent():
    """Fails if size, paint or body follow from one another: all pairs of them, by their joint histogram."""
    drawn, roster = [], Roster(1, redraw_default_sizes=True)
    roster.add("ego", Kind.CAR, SUMO_CAR, "ego")
    for number in range(3000):
        car = roster.add(number, Kind.CAR, SUMO_CAR)
        drawn.append([*car.size, car.reflectivity, actor_rng(1, car.name, Stream.PROPORTIONS).random()])
    assert min(dependence(one, other) for one, other in combinations(np.transpose(drawn), 2)) > 1e-3
