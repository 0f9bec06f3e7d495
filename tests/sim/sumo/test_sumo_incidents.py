"""Surprises of SUMO traffic with the real libsumo: collisions, bodies that pop up, nets without lanes on junctions."""

from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from support.paths import CATALOG, NETS

from luxloop.scenarios.grading.truth_events.event_log import EventLog
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.process.process_source import ProcessSource
from luxloop.sim.source import EgoCommand, TrafficEndedError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

CROSSING = CATALOG / "urban/sumo-crossing/crossing.net.xml"
NO_LINKS = NETS / "no-links/no-links.net.xml"
STEADY = '<vType id="steady" sigma="0" speedDev="0"/>'

BLOCKED = f"""{STEADY}
<vehicle id="halted" type="steady" depart="0" departPos="stop" departLane="1"><route edges="west_in east_out"/>
    <stop lane="west_in_1" startPos="55" endPos="70" duration="99"/></vehicle>
<vehicle id="ego" type="steady" depart="0" departPos="15" departLane="1" departSpeed="10">
    <route edges="west_in east_out"/></vehicle>"""
"""A car stands 40 m ahead of the ego."""

WATCHED = """<vehicle id="ego" depart="0" departPos="stop" departLane="1"><route edges="east_in"/>
    <stop lane="east_in_1" startPos="60" endPos="90" duration="900"/></vehicle>"""
"""A standing ego on the arm from the east."""

BLIND = f"""{STEADY}<vType id="blind" sigma="0" speedDev="0" decel="0.2" emergencyDecel="0.2" apparentDecel="0.2"
    lcStrategic="-1" lcSpeedGain="0" lcKeepRight="0" lcCooperative="-1"/>"""
"""A type that can hardly brake and does not change lanes."""

HIT = f"""{BLIND}{WATCHED}
<vehicle id="hitter" type="blind" depart="1" departPos="40" departLane="1" departSpeed="10" insertionChecks="none">
    <route edges="east_in west_out"/></vehicle>"""
"""A car drives into the standing ego after 5 s."""

HITTING = f"""{BLIND}
<vehicle id="halted" type="steady" depart="0" departPos="stop" departLane="1"><route edges="west_in east_out"/>
    <stop lane="west_in_1" startPos="55" endPos="70" duration="99"/></vehicle>
<vehicle id="ego" type="blind" depart="0" departPos="15" departLane="1" departSpeed="10" insertionChecks="none">
    <route edges="west_in east_out"/></vehicle>"""
"""The ego drives into a standing car."""

SIDE_BY_SIDE = f"""{BLIND}{WATCHED}
<vType id="right" sigma="0" speedDev="0" latAlignment="right" minGapLat="0"/>
<vType id="left" sigma="0" speedDev="0" latAlignment="left" minGapLat="0" decel="0.2" emergencyDecel="0.2"
    apparentDecel="0.2" lcSublane="0"/>
<vehicle id="halted" type="right" depart="0" departPos="stop" departLane="2" departPosLat="right">
    <route edges="east_in south_out"/><stop lane="east_in_2" startPos="60" endPos="80" duration="99"/></vehicle>
<vehicle id="left" type="left" depart="1" departPos="30" departLane="2" departSpeed="10" departPosLat="left"
    insertionChecks="none"><route edges="east_in south_out"/></vehicle>"""
"""In the lane beside the ego a car drives past a standing one, 1.4 m to the left: both are 1.8 m wide."""

BAY = f"""{STEADY}<vType id="bus" vClass="bus" length="12" width="2.5" sigma="0" speedDev="0"/>{WATCHED}
<vehicle id="line" type="bus" depart="0" departPos="20" departLane="1" departSpeed="8"><route edges="east_in west_out"/>
    <stop lane="east_in_1" startPos="95" endPos="130" duration="6" parking="true"/></vehicle>"""

LATE = """<vehicle id="late" depart="4" departPos="40" departLane="1" departSpeed="13">
    <route edges="east_in west_out"/></vehicle>"""


def play(tmp_path, traffic, seconds, *, speed_mps=None, net=CROSSING, masked=None, **keys):
    """Return the events of a run, and the reason of its end. `masked` gets the names that each frame does not grade."""
    (tmp_path / "traffic.rou.xml").write_text(f"<routes>{traffic}</routes>")
    if speed_mps is not None:
        keys |= {"ego_control": True, "physical": PhysicalConfig(lookahead_s=0.0)}
    config = SumoTraffic(net=str(net), routes=["traffic.rou.xml"], ego="vehicle:ego", **keys)
    log, reason = EventLog(0.1, 50.0, 200.0), ""
    with closing(SumoSource(config, tmp_path, 200.0)) as source:
        source.reset(1)
        try:
            for _ in range(round(seconds / source.dt)):
                frame = source.step()
                count = len(frame.actors)
                events = log.add(frame, SimpleNamespace(hits=np.ones(count), visible_fraction=np.ones(count)))
                if masked is not None:
                    masked.append(set(frame.actors.name[events.masked].tolist()))
                if speed_mps is not None:
                    source.apply(EgoCommand(speed_mps=speed_mps))
        except TrafficEndedError as end:
            reason = str(end)
            log.end(end.collisions)
    return log.table(), reason


def test_an_ego_that_drives_through_a_car_collides(tmp_path):
    table, reason = play(tmp_path, BLOCKED, 9.0, speed_mps=10.0)
    assert reason == ""  # with collision.action = warn, SUMO lets it
    (event,) = table.to_dict("records")
    assert (event["kind"], event["name"], event["other"]) == ("ego_collision", "halted", "ego")
    assert event["value"] > 5.0  # m^2, nearly the whole body of 5 m x 1.8 m


@pytest.mark.parametrize(("action", "what"), [("teleport", "teleported"), ("remove", "removed")])
def test_the_end_of_an_ego_that_collides_names_the_collision(tmp_path, action, what):
    _, reason = play(tmp_path, BLOCKED, 9.0, speed_mps=10.0, options={"collision.action": action})
    assert f'it collided with "halted", and SUMO {what} it' in reason
    assert 'options."collision.action" = "warn"' in reason


@pytest.mark.parametrize("lookahead_s", [0.0, 0.96])
def test_a_car_that_hits_the_ego_and_is_teleported_collides(tmp_path, lookahead_s):
    """SUMO's default. It acts when the gap is below `minGap`, before the bodies overlap."""
    table, reason = play(tmp_path, HIT, 8.0, physical=PhysicalConfig(lookahead_s=lookahead_s))
    assert reason == ""
    (event,) = table[table["kind"] == "ego_collision"].to_dict("records")
    assert (event["name"], event["other"], event["quantity"]) == ("hitter", "ego", "speed_mps")
    assert event["value"] == pytest.approx(9.2, abs=0.3)
    assert event["range_m"] < 9.0  # from centre to centre, at the contact and not at the place after it
    (teleport,) = table[table["kind"] == "teleport"].to_dict("records")
    assert (teleport["name"], teleport["frame"]) == ("hitter#2", event["frame"])


@pytest.mark.parametrize("lookahead_s", [0.0, 0.96])
def test_an_ego_that_hits_a_car_and_is_teleported_collides_in_its_last_frame(tmp_path, lookahead_s):
    table, reason = play(tmp_path, HITTING, 8.0, physical=PhysicalConfig(lookahead_s=lookahead_s))
    assert 'it collided with "halted", and SUMO teleported it' in reason
    (event,) = table.to_dict("records")
    assert (event["kind"], event["name"], event["quantity"]) == ("ego_collision", "halted", "speed_mps")
    assert event["value"] == pytest.approx(9.0, abs=0.3)
    assert event["range_m"] < 9.0


def test_a_gap_below_min_gap_is_no_collision_if_sumo_only_warns(tmp_path):
    """A car stops 1 m behind the ego: SUMO reports a collision in every step, and no body touches another."""
    near = f"""{STEADY}{WATCHED}<vType id="pushy" minGap="0.5" sigma="0" speedDev="0" collisionMinGapFactor="4"/>
    <vehicle id="near" type="pushy" depart="1" departPos="60" departLane="1" departSpeed="8">
        <route edges="east_in west_out"/><stop lane="east_in_1" startPos="70" endPos="84" duration="99"/></vehicle>"""
    table, _ = play(tmp_path, near, 8.0, options={"collision.action": "warn"})
    assert "ego_collision" not in set(table["kind"])


def test_cars_that_overlap_in_sublane_traffic_are_found_and_not_graded(tmp_path):
    options, masked = {"lateral-resolution": "0.4", "collision.action": "warn"}, []
    table, _ = play(tmp_path, SIDE_BY_SIDE, 9.0, options=options, masked=masked)
    (event,) = table.to_dict("records")
    assert (event["kind"], {event["name"], event["other"]}) == ("overlap", {"halted", "left"})
    assert 1.0 < event["value"] < 2.0  # m^2, a strip of 0.4 m along most of the cars
    overlapping = masked[event["frame"] : event["end_frame"] + 1]
    assert len(overlapping) > 8
    assert all(names == {"halted", "left"} for names in overlapping)
    assert not any(masked[: event["frame"]] + masked[event["end_frame"] + 1 :])


def test_sumo_teleports_a_car_before_it_overlaps_in_sublane_traffic(tmp_path):
    """Its default also of sublane traffic: no overlap is delivered."""
    masked = []
    table, _ = play(tmp_path, SIDE_BY_SIDE, 9.0, options={"lateral-resolution": "0.4"}, masked=masked)
    (event,) = table.to_dict("records")
    assert (event["kind"], event["name"], event["other"]) == ("teleport", "left#2", "left")
    assert masked[event["frame"]] == {"left#2"}


def test_a_bus_that_sumo_moves_into_its_bay_drives_there(tmp_path):
    """SUMO moves it by 6.1 m, past the pavement of 2 m. The truth has neither a jump nor another actor."""
    table, _ = play(tmp_path, BAY, 25.0)
    assert not set(table["kind"]) & {"teleport", "id_change", "insertion", "removal", "limit_violation"}


def test_a_car_that_is_inserted_beside_the_ego_is_an_insertion_in_view(tmp_path):
    table, _ = play(tmp_path, WATCHED + LATE, 8.0)
    (event,) = table[table["kind"] == "insertion"].to_dict("records")
    assert event["name"] == "late"
    assert event["time_s"] == pytest.approx(4.0, abs=0.17)
    assert event["speed_mps"] == pytest.approx(13.0, abs=1.0)


ACROSS = f"""{STEADY}
<vehicle id="turning" type="steady" depart="0" departPos="45" departSpeed="10"><route edges="wc cn"/></vehicle>
<vehicle id="ego" type="steady" depart="0" departPos="20" departSpeed="10"><route edges="wc cn"/></vehicle>"""


def test_a_net_without_lanes_across_junctions_is_named(tmp_path):
    table, reason = play(tmp_path, ACROSS, 15.0, net=NO_LINKS)
    assert "no lanes across its junctions (netconvert --no-internal-links)" in reason
    assert ("teleport", "turning", "") in {(row["kind"], row["name"], row["other"]) for _, row in table.iterrows()}
    assert not table["name"].str.contains("#").any()


@pytest.mark.parametrize(("net", "count"), [(NO_LINKS, 1), (CROSSING, 0)])
def test_a_net_without_lanes_across_junctions_is_warned_of_from_its_process(tmp_path, net, count):
    (tmp_path / "traffic.rou.xml").write_text(f"<routes>{ACROSS if count else BLOCKED}</routes>")
    config = SumoTraffic(net=str(net), routes=["traffic.rou.xml"], ego="vehicle:ego")
    with closing(ProcessSource(SumoSource(config, tmp_path, 200.0), "SUMO")) as source:
        source.reset(1)
        assert len(source.warnings) == count
        assert all("--no-internal-links" in line and "sim.limit_violations" in line for line in source.warnings)
