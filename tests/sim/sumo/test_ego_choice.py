"""Choice of the ego in SUMO: classes, first, best, waiting, and the reasons of refusals."""

import libsumo
import numpy as np
import pytest
from support.paths import CATALOG

from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.source import TrafficEndedError, TrafficInputError
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.sumo.survey import SumoSurvey

CROSSING = CATALOG / "urban/sumo-crossing/crossing.net.xml"
TYPES = """<vType id="calm" sigma="0" speedDev="0"/><vType id="tram" vClass="tram"/><vType id="bike" vClass="bicycle"/>
    <vType id="truck" vClass="truck" length="10" width="2.5"/><vType id="shaped" guiShape="bicycle" length="1.6"/>
    <route id="east" edges="west_in east_out"/><route id="west" edges="east_in west_out"/>"""


def parked(name, lane, position, kind="calm"):
    """Return a vehicle that stands with its front bumper at a position [m] of a lane of west_in."""
    return (
        f'<vehicle id="{name}" type="{kind}" route="east" depart="0" departPos="stop" departLane="{lane}">'
        f'<stop lane="west_in_{lane}" startPos="{position - 20}" endPos="{position}" duration="900"/></vehicle>'
    )


def vehicle(name, depart=0.0, kind="calm", route="east", lane=1, **keys):
    more = " ".join(f'{key}="{value}"' for key, value in keys.items())
    return f'<vehicle id="{name}" type="{kind}" route="{route}" depart="{depart}" departLane="{lane}" {more}/>'


@pytest.fixture
def folder(tmp_path):
    """Return a function that writes a route file and returns the traffic."""

    def write(traffic, **keys):
        (tmp_path / "traffic.rou.xml").write_text(f"<routes>{TYPES}{traffic}</routes>")
        return SumoTraffic(**{"net": str(CROSSING), "routes": ["traffic.rou.xml"]} | keys), tmp_path

    return write


@pytest.fixture
def source(folder):
    """Return a function that makes sources, which are closed at the end."""
    made = []

    def make(traffic, range_m=200.0, **keys):
        made.append(SumoSource(*folder(traffic, **keys), range_m))
        return made[-1]

    yield make
    for one in made:
        one.close()


# ---- classes


def test_first_skips_vehicles_that_cannot_carry_the_rig(source):
    traffic = vehicle("t", kind="tram") + vehicle("b", kind="bike", departPos=40) + vehicle("s", kind="shaped", lane=2)
    made = source(traffic + vehicle("car", depart=5))
    made.reset(1)
    assert made.ego_name == "car"


def test_a_named_tram_is_refused_unless_any_class_is_accepted(source):
    with pytest.raises(
        TrafficInputError, match=r'ego = "vehicle:t" is a tram, which cannot carry the rig; name a road'
    ):
        source(vehicle("t", kind="tram"), ego="vehicle:t").reset(1)
    made = source(vehicle("t", kind="tram"), ego="vehicle:t", ego_any_class=True)
    made.reset(1)
    assert made.ego_name == "t"


def test_a_route_with_bicycles_only_names_the_reason(source):
    traffic = vehicle("b", kind="bike", departPos=40) + vehicle("car", route="west", depart=3)
    with pytest.raises(TrafficInputError, match=r"on this route only a bicycle entered .* cannot carry the rig"):
        source(traffic, ego="route:east", max_wait_s=10.0).reset(1)


@pytest.mark.parametrize("keys", [{}, {"min_vehicles": 1}, {"ego": "best"}])
def test_traffic_of_trams_and_bicycles_has_no_ego(source, keys):
    traffic = vehicle("t", kind="tram") + vehicle("b", kind="bike", departPos=40)
    with pytest.raises(TrafficInputError, match=r"\(1 bicycle, 1 tram\) cannot carry the rig; add cars"):
        source(traffic, max_wait_s=20.0, **keys).reset(1)


def test_traffic_without_vehicles_says_so(source):
    person = '<person id="p" depart="0"><walk edges="west_in" arrivalPos="100"/></person>'
    with pytest.raises(TrafficInputError, match=r"no vehicle entered in \d+ s \(1 people did\)"):
        source(person, max_wait_s=20.0).reset(1)


# ---- waiting for neighbours


def test_first_with_min_vehicles_takes_a_vehicle_that_has_them(source):
    # "early" drives alone and is gone before the others enter; then "late" is among them with all its route left
    others = "".join(vehicle(f"o{n}", depart=60 + n, lane=2) for n in range(3))
    made = source(vehicle("early", departSpeed="max") + others + vehicle("late", depart=65), min_vehicles=3)
    made.reset(1)
    assert made.ego_name == "late"
    assert len(made.step().actors) >= 3


def test_first_that_finds_too_few_names_the_most(source):
    with pytest.raises(
        TrafficInputError, match=r'min_vehicles = 3: .* within 200 m; the most were 1, around ".*"; lower it$'
    ):
        source(vehicle("a") + vehicle("b", depart=3), min_vehicles=3).reset(1)


def test_an_ego_that_arrives_while_it_waits_is_not_told_to_wait_longer(source):
    with pytest.raises(TrafficInputError) as error:
        source(vehicle("ego") + parked("block", 2, 100), ego="vehicle:ego", min_vehicles=5).reset(1)
    assert "when it left the net; choose another ego (luxloop egos lists them)" in str(error.value)
    assert "max_wait_s" not in str(error.value)


def test_an_ego_that_does_not_exist_is_not_told_to_wait_longer_after_the_last_vehicle(source):
    with pytest.raises(TrafficInputError, match=r"these did: a; no vehicle is left to enter") as error:
        source(vehicle("a"), ego="vehicle:b").reset(1)
    assert "max_wait_s" not in str(error.value)


def test_frames_begin_at_a_time(source):
    made = source(vehicle("ego"), ego="vehicle:ego", frames_from_s=5.0)
    made.reset(1)
    made.step()
    at_5_s = libsumo.simulation.getTime()
    made.close()
    made = source(vehicle("ego"), ego="vehicle:ego")
    made.reset(1)
    made.step()
    # both have the same look-ahead; the ego enters in the first step
    assert at_5_s - libsumo.simulation.getTime() == pytest.approx(5.0 - 0.08, abs=0.081)


@pytest.mark.parametrize(
    ("keys", "why"),
    [
        ({"frames_from_s": 200.0}, r'ego "ego" left the net at \d+ s .* choose an ego that stays longer'),
        ({"frames_from_s": 20.0, "max_wait_s": 10.0}, "max_wait_s ended at 10 s .* raise max_wait_s"),
    ],
)
def test_a_late_begin_names_the_reason(source, keys, why):
    with pytest.raises(TrafficInputError, match=why):
        source(vehicle("ego"), ego="vehicle:ego", **keys).reset(1)


# ---- survey and best


def survey(traffic, folder, seconds):
    log, one = CandidateLog(200.0, 50.0), SumoSurvey(traffic, folder)
    try:
        one.reset(1)
        for _ in range(round(seconds / one.dt)):
            log.add(one.step())
    except TrafficEndedError:
        pass
    finally:
        one.close()
    found = log.candidates()
    return found, {body.name: row for row, body in enumerate(found.bodies)}


def test_figures_of_standing_vehicles_equal_those_by_hand(folder):
    # On lane 1: the ego's centre at 57.5 m, a truck from 75 to 85 m, a car behind it; on lane 2 a car at 72.5 m.
    traffic = parked("ego", 1, 60) + parked("truck", 1, 85, "truck") + parked("behind", 1, 100) + parked("side", 2, 75)
    found, row = survey(*folder(traffic), 12.0)
    assert found.near[row["ego"]] == 3
    # of 3 neighbours one is hidden: the line to "behind" passes through the truck, that to "side" is free
    assert found.occlusion[row["ego"]] == pytest.approx(1 / 3)
    assert found.occlusion[row["truck"]] == 0.0
    assert (found.distance_m[row["ego"]], found.stops[row["ego"]], found.turns[row["ego"]]) == (0.0, 0, 0.0)
    assert found.stay_s[row["ego"]] == pytest.approx(12.0, abs=2.0)


def test_figures_of_a_driving_vehicle_equal_those_by_hand(folder):
    stop = '<stop lane="west_in_1" endPos="60" duration="5"/>'
    begin = 'route="east" depart="0" departPos="20" departSpeed="5" departLane="1"'
    traffic = f"""<vType id="slow" maxSpeed="5" sigma="0" speedDev="0" accel="50" decel="50" tau="1"/>
        <vehicle id="a" type="slow" {begin}>{stop}</vehicle>
        <vehicle id="tram" type="tram" route="west" depart="0" departLane="1"/>"""
    found, row = survey(*folder(traffic), 15.0)
    a = row["a"]
    # 40 m at 5 m/s, the stop of 5 s, and 2 s at 5 m/s until 15 s
    assert found.stops[a] == 1
    assert found.distance_m[a] == pytest.approx(5.0 * (found.stay_s[a] - 5.0), abs=6.0)
    assert found.suitable.tolist() == [name != "tram" for name in row]


def test_a_survey_sees_the_traffic_of_the_run(source, folder):
    flow = '<flow id="f" type="calm" route="west" begin="0" period="3" departLane="random"/>'
    found, row = survey(*folder(flow), 30.0)
    made = source(flow, ego="vehicle:f.2")
    made.reset(1)
    # the run's ego enters when the survey saw it first, to the survey's second
    entered = libsumo.vehicle.getDeparture("f.2")
    assert found.enters_s[row["f.2"]] == pytest.approx(entered, abs=1.0)
    assert found.enters_s[row["f.2"]] >= entered


def test_best_is_the_first_candidate_and_repeats(source, folder):
    flows = "".join(
        f'<flow id="{route}" type="calm" route="{route}" begin="0" end="120" period="4" departLane="random"/>'
        for route in ("east", "west")
    )
    for want in ("", ":long", ":stops"):
        traffic, place = folder(flows)
        found, _ = survey(traffic, place, 150.0)
        expected = found.bodies[found.order(*([want[1:]] if want else []))[0]].name
        names = []
        for _ in range(2):
            made = source(flows, ego=f"best{want}", max_wait_s=150.0)
            made.reset(1)
            names.append(made.ego_name)
            assert np.isfinite(made.step().ego.pose_world).all()
            made.close()
        assert names == [expected, expected]


def test_an_unknown_want_of_best_is_rejected():
    with pytest.raises(ValueError, match="neighbours, turns, stops, occlusion, long"):
        SumoTraffic(config="x.sumocfg", ego="best:speed")
