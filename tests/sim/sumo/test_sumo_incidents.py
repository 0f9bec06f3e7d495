"""Surprises of SUMO traffic with the real libsumo: collisions, bodies that pop up, nets without lanes on junctions."""

from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest
from support.paths import CATALOG, NETS

from scenarios.grading.truth_events.event_log import EventLog
from sim.physical.physical_config import PhysicalConfig
from sim.process.process_source import ProcessSource
from sim.source import EgoCommand, TrafficEndedError
from sim.sumo.sumo_config import SumoTraffic
from sim.sumo.sumo_source import SumoSource

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

BAY = f"""{STEADY}<vType id="bus" vClass="bus" length="12" width="2.5" sigma="0" speedDev="0"/>{WATCHED}
<vehicle id="line" type="bus" depart="0" departPos="20" departLane="1" departSpeed="8"><route edges="east_in west_out"/>
    <stop lane="east_in_1" startPos="95" endPos="130" duration="6" parking="true"/></vehicle>"""

LATE = """<vehicle id="late" depart="4" departPos="40" departLane="1" departSpeed="13">
    <route edges="east_in west_out"/></vehicle>"""


def play(tmp_path, traffic, seconds, *, speed_mps=None, net=CROSSING, **keys):
    """Return the events of a run, and the reason of its end."""
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
                log.add(frame, SimpleNamespace(hits=np.ones(count), visible_fraction=np.ones(count)))
                if speed_mps is not None:
                    source.apply(EgoCommand(speed_mps=speed_mps))
        except TrafficEndedError as end:
            reason = str(end)
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
