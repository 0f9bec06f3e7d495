"""Identity of road users in SUMO traffic: at stops beside the road, and where SUMO skips the way across a junction."""

from contextlib import closing
from types import SimpleNamespace

import libsumo
import numpy as np
import pytest
from support.paths import NETS

from luxloop.scenarios.grading.truth_events.event_log import EventLog
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

BUS = """<vType id="bus" vClass="bus" length="12" width="2.5" sigma="0" speedDev="0"/>
<vehicle id="ego" depart="0" departPos="4" departLane="{lane}" departSpeed="0"><route edges="{edge}"/>
    <stop lane="{edge}_{lane}" endPos="8" duration="999"/></vehicle>
<vehicle id="line" type="bus" depart="0" departPos="22" departLane="{lane}" departSpeed="6"><route edges="{edge}"/>
    <stop busStop="bay" duration="6" parking="true"/></vehicle>"""
STOP = '<busStop id="bay" lane="{edge}_{lane}" startPos="60" endPos="{end}"/>'
"""A bus calls at a stop beside the road; the ego stands behind it."""


@pytest.fixture
def run(tmp_path):
    """Return a function that plays traffic on a test net: its frames, SUMO's positions and its truth events."""

    def play(net, traffic, seconds, shapes=""):
        (tmp_path / "traffic.rou.xml").write_text(f"<routes>{traffic}</routes>")
        (tmp_path / "shapes.add.xml").write_text(f"<additional>{shapes}</additional>")
        config = SumoTraffic(
            net=str(NETS / net / f"{net}.net.xml"),
            routes=["traffic.rou.xml"],
            additional=["shapes.add.xml"],
            ego="vehicle:ego",
        )
        log, seen, places = EventLog(0.1, 150.0, 200.0), [], []
        with closing(SumoSource(config, tmp_path, 200.0)) as source:
            source.reset(1)
            for _ in range(round(seconds / source.dt)):
                seen.append(source.step())
                count = len(seen[-1].actors)
                log.add(seen[-1], SimpleNamespace(hits=np.ones(count), visible_fraction=np.ones(count)))
                buses = {"line"} & {*libsumo.vehicle.getIDList()}
                places += [np.array(libsumo.vehicle.getPosition(name)) - source.origin for name in buses]
        return seen, np.array(places), log.table()

    return play


def of(seen, name):
    """Return ids, poses and speeds of the actor whose name begins with `name`, one per frame."""
    rows = [(frame.actors, n) for frame in seen for n, label in enumerate(frame.actors.name) if label.startswith(name)]
    ids, names = {int(actors.id[n]) for actors, n in rows}, {str(actors.name[n]) for actors, n in rows}
    pose = np.array([actors.pose_world[n] for actors, n in rows])
    return ids, names, pose, np.array([np.hypot(*actors.velocity_world[n]) for actors, n in rows])


@pytest.mark.parametrize(
    ("net", "edge", "lane", "end"),
    [("winding", "r200", 0, 110.0), ("left-hand", "A0left0", 1, 85.0)],
)
def test_a_bus_drives_into_its_bay_and_out_of_it_as_the_same_actor(run, net, edge, lane, end):
    keys = {"edge": edge, "lane": lane, "end": end}
    seen, places, events = run(net, BUS.format(**keys), 34.0, STOP.format(**keys))
    ids, names, pose, speed = of(seen, "line")
    assert (len(ids), names) == (1, {"line"})
    assert not set(events["kind"]) & {"teleport", "id_change", "limit_violation"}
    jump = np.hypot(*np.diff(places, axis=0).T)
    assert (jump > 3.0).sum() == 2, "SUMO moved the bus beside the road and back: 3.2 m and the lanes in between"
    # it stands where SUMO puts it, within half of the truth layer's largest deviation
    parked = places[np.flatnonzero(jump > 3.0)[0] + 1]
    (standing,) = np.unique(pose[speed == 0.0], axis=0)
    front = standing[:2] + 6.0 * np.array([np.cos(standing[2]), np.sin(standing[2])])
    assert front == pytest.approx(parked, abs=0.5)
    # and it drives there: no body moves sideways
    step = np.diff(pose[:, :2], axis=0)
    course, moving = np.arctan2(step[:, 1], step[:, 0]), speed[1:] > 0.5
    drift = np.angle(np.exp(1j * (course - pose[1:, 2])))[moving]
    assert np.abs(drift).max() < np.radians(12.0)


WALK = """<vType id="w" vClass="pedestrian" speedDev="0"/>
<vehicle id="ego" depart="0" departPos="40"><route edges="{first}"/>
    <stop lane="{first}_{lane}" endPos="50" duration="999"/></vehicle>
<person id="walker" type="w" depart="0" departPos="-8"><walk edges="{first} {second}" arrivalPos="30"/></person>"""


@pytest.mark.parametrize(
    ("net", "first", "second", "lane", "skipped_m"),
    [("no-links", "wc", "ce", 0, 11.3), ("left-hand", "A1A0", "A0left0", 1, 19.8)],
)
def test_a_person_whom_sumo_moves_across_a_junction_stays_the_same(run, net, first, second, lane, skipped_m):
    """The nets have no way for people across the junction: SUMO skips it in one step."""
    seen, _, events = run(net, WALK.format(first=first, second=second, lane=lane), 20.0)
    ids, names, pose, _ = of(seen, "walker")
    assert (len(ids), names) == (1, {"walker"})
    step = np.hypot(*np.diff(pose[:, :2], axis=0).T)
    assert np.sort(step)[-1] == pytest.approx(skipped_m, abs=0.4)
    assert np.sort(step)[-2] < 0.2  # no smoothing across the skipped way
    (event,) = events[events["kind"] == "teleport"].to_dict("records")
    assert (event["name"], event["other"]) == ("walker", "")
    assert event["value"] == pytest.approx(skipped_m, abs=0.4)
