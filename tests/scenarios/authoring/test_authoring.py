"""`luxloop egos` and `luxloop new`: every kind of source, and runs of what they write."""

import gzip
import io
import json
import shutil
import tomllib
from contextlib import redirect_stdout
from functools import partial

import numpy as np
import pytest
from support.optional import need
from support.paths import CATALOG, NETS

from luxloop.scenarios.authoring import new_scenario
from luxloop.scenarios.authoring.draft import Draft, TypeGuesses
from luxloop.scenarios.authoring.new_scenario import scenario_text
from luxloop.scenarios.authoring.traffic_input import files_beside, read_input
from luxloop.scenarios.cli import main
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run.warm_up import car_ahead
from luxloop.sim.source import TrafficEndedError
from luxloop.sim.world import Collision

CROSSING = CATALOG / "urban/sumo-crossing"
WIZARD = NETS / "osm-wizard"


def write(out, source, *options, duration="4"):
    """Write a scenario from a source; return the scenario and the choices."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        assert main(["new", str(source), "--out", str(out), "--duration", duration, "--json", *options]) == 0
    document = json.loads(printed.getvalue())
    assert document["out"] == str(out)
    return Scenario.load(out), document["choices"]


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a scenario from a source; it returns the scenario and the choices."""
    return partial(write, tmp_path / "new.toml")


@pytest.fixture(scope="module")
def of_crossing(tmp_path_factory):
    """The scenario of the crossing's net, and its choices: several candidates are simulated for it."""
    return write(tmp_path_factory.mktemp("crossing") / "new.toml", CROSSING / "crossing.net.xml", "--window", "30")


def run(scenario, tmp_path, capfd):
    """Run a scenario file, and return the metrics of a complete run."""
    arguments = ["run", str(scenario.path), "--json", "--no-recording", "--out", str(tmp_path / "run")]
    assert main(arguments) in (0, 1)
    document = json.loads(capfd.readouterr().out)
    assert document["complete"]
    return {name: metric["value"] for name, metric in document["metrics"].items()}


# ---- luxloop new


def test_a_net_with_its_routes(of_crossing, tmp_path, capfd):
    scenario, choices = of_crossing
    assert (scenario.folder / scenario.traffic.net).resolve() == (CROSSING / "crossing.net.xml").resolve()
    assert [(scenario.folder / name).name for name in scenario.traffic.additional] == ["buildings.add.xml"]
    assert scenario.duration_s == 4.0
    assert scenario.traffic.ego.partition(":")[2] in choices[0]
    metrics = run(scenario, tmp_path, capfd)
    assert metrics["dataset.frames"] == 50
    # the busiest window of the best candidate has more than one vehicle in view
    assert metrics["dataset.observations"] > 50


@pytest.mark.slow
def test_the_output_of_sumo_s_map_import_as_it_is(written, tmp_path, capfd):
    scenario, _ = written(WIZARD, "--window", "120")
    assert scenario.traffic.config.endswith("osm.sumocfg")
    before = sorted(WIZARD.iterdir())
    assert run(scenario, tmp_path, capfd)["dataset.observations"] > 0
    assert sorted(WIZARD.iterdir()) == before  # configured outputs are not written


@pytest.mark.slow
def test_compressed_and_unsorted_trips_of_the_map_import(written, tmp_path, capfd):
    copy = tmp_path / "import"
    shutil.copytree(WIZARD, copy)
    head, *trips = (copy / "osm.passenger.trips.xml").read_text().split("    <trip ")
    trips[-1] = trips[-1].replace("</routes>", "")
    text = head + "".join(f"    <trip {trip}" for trip in reversed(trips)) + "</routes>"
    with gzip.open(copy / "osm.passenger.trips.xml.gz", "wt") as stream:
        stream.write(text)
    (copy / "osm.passenger.trips.xml").unlink()
    config = copy / "osm.sumocfg"
    config.write_text(config.read_text().replace("osm.passenger.trips.xml", "osm.passenger.trips.xml.gz"))
    counts = []
    for source in (WIZARD, copy, copy / "osm.net.xml.gz"):
        assert main(["egos", str(source), "--window", "60", "--json"]) == 0
        counts.append(json.loads(capfd.readouterr().out)["vehicles"])
    assert counts[0] == counts[1] == counts[2] > 5
    assert run(written(copy, "--window", "60")[0], tmp_path, capfd)["dataset.observations"] > 0


@pytest.mark.slow
def test_an_environment_of_highway_env(written, tmp_path, capfd):
    scenario, choices = written("highway-v0")
    assert (scenario.traffic.env, scenario.name) == ("highway-v0", "new")
    assert scenario.traffic.config["other_vehicles_type"].endswith("Motorist")
    assert "Motorist" in " ".join(choices)
    assert run(scenario, tmp_path, capfd)["dataset.observations"] > 0


@pytest.mark.slow
def test_a_table_of_trajectories(written, tmp_path, capfd):
    scenario, _ = written(CATALOG / "urban/replayed-crossing/tracks.csv.gz")
    assert scenario.traffic.kind == "replay"
    assert run(scenario, tmp_path, capfd)["dataset.observations"] > 50


def fcd(path):
    """Write floating car data of five cars of unknown types, one behind the other, and a truck."""
    kinds = ["veh_passenger"] * 5 + ["big_truck"]
    steps = [
        f'<timestep time="{t / 2}">'
        + "".join(
            f'<vehicle id="v{n}" x="{100 + 15 * n + 4 * t}" y="0" angle="90" type="{kind}" speed="8"/>'
            for n, kind in enumerate(kinds)
        )
        + "</timestep>"
        for t in range(40)
    ]
    path.write_text(f"<fcd-export>{''.join(steps)}</fcd-export>")


def test_floating_car_data_with_unknown_types(written, tmp_path, capfd):
    fcd(tmp_path / "fcd.xml")
    scenario, choices = written(tmp_path / "fcd.xml")
    types = {name: one.kind for name, one in scenario.traffic.types.items()}
    assert types == {"veh_passenger": "car", "big_truck": "truck"}
    assert scenario.traffic.ego in ("v2", "v3")  # those in the middle have all others within 50 m
    assert "guessed" in " ".join(choices)
    assert run(scenario, tmp_path, capfd)["dataset.observations"] > 50


def commonroad_file(path):
    """Write a CommonRoad file of three cars at 10 m/s for 6 s, the first in the middle."""

    def state(step, x, y, tag):
        return (
            f"<{tag}><time><exact>{step}</exact></time><position><point><x>{x}</x><y>{y}</y></point></position>"
            f"<orientation><exact>0</exact></orientation><velocity><exact>10</exact></velocity></{tag}>"
        )

    box = "<shape><rectangle><length>4.4</length><width>1.8</width></rectangle></shape>"
    cars = "".join(
        f'<dynamicObstacle id="{number}"><type>car</type>{box}{state(0, x, 0, "initialState")}<trajectory>'
        + "".join(state(k, x + k, 0, "state") for k in range(1, 61))
        + "</trajectory></dynamicObstacle>"
        for number, x in ((1, 0), (2, 15), (3, -15))
    )
    path.write_text(
        """<?xml version="1.0" ?><commonRoad timeStepSize="0.1" commonRoadVersion="2020a" author="" affiliation=""
        source="" benchmarkID="DEU_A-1_1_T-1" date="2024-01-01"><location><geoNameId>-999</geoNameId><gpsLatitude>999
        </gpsLatitude><gpsLongitude>999</gpsLongitude></location><scenarioTags><urban/></scenarioTags><lanelet id="9">
        <leftBound><point><x>0</x><y>2</y></point><point><x>99</x><y>2</y></point></leftBound><rightBound><point><x>0</x>
        <y>-2</y></point><point><x>99</x><y>-2</y></point></rightBound><laneletType>urban</laneletType></lanelet>"""
        + cars
        + "</commonRoad>"
    )


def test_commonroad(written, tmp_path, capfd):
    need("commonroad")
    commonroad_file(tmp_path / "road.xml")
    scenario, _ = written(tmp_path / "road.xml", duration="3")
    assert (scenario.traffic.kind, scenario.traffic.ego) == ("replay", "1")
    assert run(scenario, tmp_path, capfd)["dataset.observations"] > 20


def test_the_file_says_what_was_chosen_and_that_limits_are_defaults(written):
    scenario, choices = written(CROSSING / "crossing.net.xml", "--window", "60", "--want", "occlusion")
    text = scenario.path.read_text()
    comments = " ".join(line[2:] for line in text.splitlines() if line.startswith("# "))
    for choice in choices:
        assert " ".join(choice.split()) in comments
    assert "by occlusion" in comments
    assert "generic defaults" in comments
    for limit in scenario.expect.values():
        assert limit.unit
        assert limit.need
    # the limits do not depend on the traffic
    assert scenario.expect["dataset.observations"].min == 0.5 * 12.5 * 4
    assert scenario.expect["track.id_switches_in_view"].max == 1


class Crashing:
    """Traffic that ends after 50 frames, because a car that no frame shows hits the ego."""

    dt, warnings, ego_name = 0.08, (), "ego"

    def reset(self, _):
        self.frames = map(car_ahead, range(50))

    def step(self):
        if (frame := next(self.frames, None)) is None:
            raise TrafficEndedError("the ego collided", (Collision(-1, "hitter", 9.0),))
        return frame

    def close(self):
        """Do nothing."""


def test_an_ego_that_is_hit_at_the_end_is_not_kept_for_a_shorter_run(tmp_path, monkeypatch):
    """A window that ends just before the collision would pass its own check."""
    monkeypatch.setattr(new_scenario, "make_source", lambda *_: Crashing())
    out = tmp_path / "new.toml"
    draft = Draft("a draft", {"kind": "highway-env", "env": "highway-v0"}, duration_s=8.0, seed=1)
    rehearsal = new_scenario.rehearse(Scenario.of(draft.document(), out))
    assert (rehearsal.frames, rehearsal.is_hit) == (50, True)
    assert new_scenario.grade(draft, rehearsal, out).failed == ["sim.ego_collisions = 1, limit <= 0 (the ego collided)"]


def test_an_ego_that_a_car_hits_is_refused_since_its_own_limit_would_fail(tmp_path, capfd):
    """A car that can hardly brake drives into an ego that waits at the side of its lane."""
    steady = 'sigma="0" speedDev="0"'
    (tmp_path / "hit.rou.xml").write_text(f"""<routes><vType id="steady" {steady}/>
        <vType id="blind" {steady} decel="0.2" emergencyDecel="0.2" apparentDecel="0.2"
            lcStrategic="-1" lcSpeedGain="0" lcKeepRight="0" lcCooperative="-1"/>
        <vehicle id="ego" type="steady" depart="0" departPos="stop" departLane="1"><route edges="east_in"/>
            <stop lane="east_in_1" startPos="60" endPos="90" duration="20"/></vehicle>
        <vehicle id="other" type="steady" depart="0" departPos="base" departLane="2" departSpeed="1">
            <route edges="west_in east_out"/></vehicle>
        <vehicle id="hitter" type="blind" depart="0.5" departPos="60" departLane="1" departSpeed="10"
            insertionChecks="none"><route edges="east_in west_out"/></vehicle></routes>""")
    shutil.copy(CROSSING / "crossing.net.xml", tmp_path)
    out = tmp_path / "new.toml"
    options = ["--ego", "ego", "--begin", "0", "--window", "8", "--duration", "4", "--out", str(out)]
    assert main(["new", str(tmp_path / "crossing.net.xml"), *options]) == 2
    err = capfd.readouterr().err
    assert "the limits that the file would have fail in all 1 choices of ego and window" in err
    assert "sim.ego_collisions = 1, limit <= 0" in err
    assert err.endswith("choose another --ego, --want, --begin or --window, or repair the traffic\n")
    assert not out.exists()


def test_the_window_has_as_many_neighbours_as_it_says(of_crossing):
    scenario, choices = of_crossing
    from luxloop.scenarios.authoring.new_scenario import rehearse

    found = rehearse(scenario)
    assert f"with {found.near:.1f} vehicles in the range of grading" in choices[-1]
    assert found.complete
    assert found.near >= 1.0


@pytest.mark.slow
def test_an_ego_that_was_asked_for(of_crossing, written, capfd, tmp_path):
    best, _ = of_crossing  # its limits hold
    ego = best.traffic.ego.removeprefix("vehicle:")
    scenario, choices = written(CROSSING / "crossing.net.xml", "--window", "60", "--ego", ego, "--force")
    assert scenario.traffic.ego == best.traffic.ego
    assert "as asked for" in choices[0]
    arguments = [
        str(CROSSING / "crossing.net.xml"),
        "--out",
        str(tmp_path / "x.toml"),
        "--window",
        "20",
        "--ego",
        "no-such",
    ]
    assert main(["new", *arguments]) == 2
    assert "--ego no-such: did not enter within 20 s; see luxloop egos" in capfd.readouterr().err
    assert not (tmp_path / "x.toml").exists()


# ---- refusals


def write_traffic(folder, traffic):
    shutil.copy(CROSSING / "crossing.net.xml", folder / "x.net.xml")
    (folder / "x.rou.xml").write_text(f"<routes>{traffic}</routes>")
    return str(folder / "x.net.xml")


@pytest.mark.parametrize(
    ("traffic", "why"),
    [
        (
            '<vType id="tram" vClass="tram"/><vehicle id="t" type="tram" depart="0"><route edges="west_in"/></vehicle>',
            "(1 tram) cannot carry the rig",
        ),
        (
            '<person id="p" depart="0"><walk edges="west_in" arrivalPos="50"/></person>',
            "no vehicle enters within 30 s, and people cannot carry the rig",
        ),
        (
            '<vehicle id="alone" depart="0"><route edges="west_in east_out"/></vehicle>',
            "no vehicle comes within the range",
        ),
        ('<vehicle id="late" depart="90"><route edges="west_in"/></vehicle>', "give --begin shortly before"),
    ],
)
def test_traffic_without_an_ego_is_refused_with_the_true_cause(tmp_path, capfd, traffic, why):
    source = write_traffic(tmp_path, traffic)
    assert main(["new", source, "--out", str(tmp_path / "o.toml"), "--window", "30", "--duration", "5"]) == 2
    error = capfd.readouterr().err
    assert why in error
    assert error.count("\n") == 1
    assert not (tmp_path / "o.toml").exists()


@pytest.mark.parametrize(
    ("source", "out", "why"),
    [
        ("no/such.net.xml", "o.toml", "no/such.net.xml: no such file"),
        ("highway-v9", "o.toml", 'env = "highway-v9" is unknown; did you mean'),
        ("highway-v0", "o.txt", "a scenario file must end in .toml"),
        ("highway-v0", "no/o.toml", "its folder does not exist"),
        ("highway-v0", "there.toml", "exists already; give another name, or --force"),
        (str(NETS / "mixed.rou.xml"), "o.toml", "its root is <routes>; give a SUMO net"),
    ],
)
def test_bad_arguments_of_new(tmp_path, capfd, source, out, why):
    (tmp_path / "there.toml").write_text("mine")
    assert main(["new", source, "--out", str(tmp_path / out)]) == 2
    assert why in capfd.readouterr().err
    assert (tmp_path / "there.toml").read_text() == "mine"


def test_a_net_without_routes(tmp_path, capfd):
    shutil.copy(CROSSING / "crossing.net.xml", tmp_path / "x.net.xml")
    assert main(["egos", str(tmp_path / "x.net.xml")]) == 2
    assert "no route file beside this net; give one with --routes" in capfd.readouterr().err


def test_names_of_nothing_are_refused_as_such(capfd):
    assert main(["egos", "sumo-crosing", "--routes", "x"]) == 2
    error = capfd.readouterr().err
    assert "sumo-crosing: no such file, scenario or environment of highway-env; did you mean sumo-crossing" in error


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("sumo-crossing", "sumo-crossing: is a scenario already; start it with luxloop run sumo-crossing"),
        (str(CATALOG / "urban/sumo-crossing.toml"), "sumo-crossing.toml: is a scenario file already; start it"),
        ("missing.toml", "missing.toml: no such file"),
    ],
)
def test_a_scenario_in_place_of_traffic_is_recognised(tmp_path, capfd, source, why):
    assert main(["new", source, "--out", str(tmp_path / "o.toml")]) == 2
    assert why in capfd.readouterr().err


@pytest.mark.parametrize("name", ["crossing.net.xml", "buildings.add.xml", ".."])
def test_routes_that_are_no_route_file_are_named(capfd, tmp_path, name):
    given = CROSSING / name if name != ".." else tmp_path
    assert main(["egos", str(CROSSING / "crossing.net.xml"), "--routes", str(given)]) == 2
    error = capfd.readouterr().err
    assert f"--routes {given}: " in error
    assert "<routes>" in error


SUMOCFG = '<configuration><input><net-file value="crossing.net.xml"/></input></configuration>'
TRACKS = "time_s,id,type,x_m,y_m,yaw_deg\n0,a,car,0,0,0\n"
UNUSED = "--routes x: {} is no net and has its own traffic"
FIRST_AGENT = "an environment of highway-env has its first agent as ego, from its start on"


@pytest.mark.parametrize(
    ("command", "source", "options", "why"),
    [
        ("egos", "a.sumocfg", "--routes x", UNUSED),
        ("egos", "sumo-crossing", "--routes x", "--routes x: sumo-crossing is a scenario and names its own routes"),
        ("new", "a.sumocfg", "--routes x", UNUSED),
        ("new", "a.csv", "--routes x", UNUSED),
        ("new", "roundabout-v0", "--routes x", UNUSED),
        ("new", "roundabout-v0", "--want turns --window 20", f"--want and --window: {FIRST_AGENT}"),
        ("new", "roundabout-v0", "--begin 5 --ego 1", f"--ego and --begin: {FIRST_AGENT}"),
        ("new", "a.csv", "--begin 5", "--begin: a recording is surveyed as a whole; leave it out"),
        ("new", "a.csv", "--window 5", "--window: a recording is surveyed as a whole; leave it out"),
    ],
)
def test_options_without_an_effect_are_refused(tmp_path, monkeypatch, capfd, command, source, options, why):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.sumocfg").write_text(SUMOCFG)
    (tmp_path / "a.csv").write_text(TRACKS)
    out = ["--out", "o.toml"] if command == "new" else []
    assert main([command, source, *out, *options.split()]) == 2
    assert why.format(source) in capfd.readouterr().err
    assert not (tmp_path / "o.toml").exists()


def test_egos_of_highway_env_are_refused(capfd):
    assert main(["egos", "merge-v0"]) == 2
    assert "only SUMO's traffic has candidates for the ego, this is highway-env" in capfd.readouterr().err


# ---- luxloop egos


def test_egos_of_a_scenario_have_all_figures(capfd):
    assert main(["egos", "sumo-crossing", "--window", "40", "--json", "--want", "stops", "--stay", "10"]) == 0
    document = json.loads(capfd.readouterr().out)
    entries = document["candidates"]
    assert len(entries) == 20
    stops = [entry["stops"] for entry in entries if entry["stay_s"] >= 10 and entry["distance_m"] >= entry["stay_s"]]
    assert stops == sorted(stops, reverse=True)
    keys = "ego class suitable enters_s stay_s distance_m neighbours near turns stops occlusion leaves"
    assert set(entries[0]) == set(keys.split())
    assert all(np.isfinite(entry["stay_s"]) and 0 <= entry["occlusion"] <= 1 for entry in entries)
    assert all(entry["neighbours"] >= entry["near"] for entry in entries)


def test_egos_lists_trams_only_if_asked(tmp_path, capfd):
    tram = '<vType id="tram" vClass="tram"/><vehicle id="t" type="tram" depart="0"><route edges="west_in"/></vehicle>'
    source = write_traffic(tmp_path, tram + '<vehicle id="car" depart="1"><route edges="east_in west_out"/></vehicle>')
    assert main(["egos", source, "--window", "10"]) == 0
    printed = capfd.readouterr().out
    assert "2 vehicles entered, 1 of which cannot carry the rig" in printed
    assert "tram" not in printed.partition("For a scenario")[0]
    assert 'ego = "vehicle:car"' in printed
    assert main(["egos", source, "--window", "10", "--any-class"]) == 0
    assert "tram" in capfd.readouterr().out


def test_egos_names_the_trips_beside_routes_of_the_same_vehicles(tmp_path, capfd):
    shutil.copy(CROSSING / "crossing.net.xml", tmp_path)
    (tmp_path / "trips.trips.xml").write_text('<routes><trip id="0" depart="0" from="west_in" to="east_out"/></routes>')
    routed = '<vehicle id="0" depart="0"><route edges="west_in east_out"/></vehicle>'
    (tmp_path / "routes.rou.xml").write_text(f"<routes>{routed}</routes>")
    line = "Left out: trips.trips.xml: its vehicles have the same ids as those of routes.rou.xml."
    assert read_input(str(tmp_path)).said_of_left_out() == [line]  # among the choices of luxloop new
    assert main(["egos", str(tmp_path), "--window", "10"]) == 0
    printed = capfd.readouterr().out
    assert printed.startswith("1 vehicle entered")
    assert line in " ".join(printed.split())
    assert main(["egos", str(tmp_path), "--window", "10", "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["left_out"] == [line]
    assert main(["egos", str(tmp_path), "--routes", str(tmp_path / "trips.trips.xml"), "--window", "10", "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["left_out"] == []


# ---- best in a run


def test_the_result_names_the_best_ego(tmp_path, capfd):
    path = tmp_path / "best.toml"
    net, routes = CROSSING / "crossing.net.xml", CROSSING / "crossing.rou.xml"
    path.write_text(
        f"""description = "d"
        duration_s = 1.0
        [traffic]
        kind = "sumo"
        net = "{net}"
        routes = ["{routes}"]
        ego = "best:turns"
        max_wait_s = 60.0"""
    )
    assert main(["run", str(path), "--no-recording", "--full", "--out", str(tmp_path / "run")]) == 0
    printed = capfd.readouterr().out
    assert main(["egos", str(path), "--window", "60", "--want", "turns", "--json"]) == 0
    expected = json.loads(capfd.readouterr().out)["candidates"][0]["ego"]
    assert f'ego "{expected}", chosen by ego = "best:turns"' in printed
    assert json.loads((tmp_path / "run/result.json").read_text())["config"]["ego"] == expected


# ---- parts


def test_routes_replace_trips_types_come_first_and_signal_programs_are_left_out(tmp_path):
    files = {
        "a.net.xml": "<net/>",
        "z.types.xml": "<routes><vType id='x'/></routes>",
        "a.rou.xml": "<!-- <configuration> --><routes><vehicle id='v'/></routes>",
        "a.trips.xml": "<routes><trip id='v'/></routes>",
        "b.trips.xml": "<routes><trip id='w'/></routes>",
        "b.rou.alt.xml": "<routes><vehicle id='w'/></routes>",
        "a.add.xml": "<additional><poly id='p'/></additional>",
        "tls.add.xml": "<additional><tlLogic id='t'/></additional>",
        "view.xml": "<viewsettings/>",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    found = files_beside(tmp_path / "a.net.xml")
    assert found.routes == ["z.types.xml", "a.rou.xml", "b.trips.xml"]
    assert found.additional == ["a.add.xml"]
    assert [name.partition(":")[0] for name in found.left_out] == ["a.trips.xml", "tls.add.xml"]


def test_of_the_two_files_of_random_trips_the_routes_are_taken_and_the_other_is_named(tmp_path):
    """randomTrips.py writes trips.trips.xml, and with -r the same vehicles with routes, into routes.rou.xml."""
    (tmp_path / "a.net.xml").write_text("<net/>")
    ids = range(3)
    trips = "".join(f'<trip id="{n}" depart="{n}.00" from="a" to="b"/>' for n in ids)
    routed = "".join(f'<vehicle id="{n}" depart="{n}.00"><route edges="a b"/></vehicle>' for n in ids)
    (tmp_path / "trips.trips.xml").write_text(f"<routes>{trips}</routes>")
    (tmp_path / "routes.rou.xml").write_text(f"<routes>{routed}</routes>")
    found = files_beside(tmp_path / "a.net.xml")
    assert found.routes == ["routes.rou.xml"]
    assert found.left_out == ["trips.trips.xml: its vehicles have the same ids as those of routes.rou.xml"]


def test_a_written_file_is_read_back():
    document = {
        "description": 'a "b" \\ ü \x7f',
        "x": [1, 2.5, True],
        "traffic": {"odd key": {"a.b": -1}, "list": ["c"]},
    }
    text = scenario_text(document, ["word " * 60])
    assert tomllib.loads(text) == document
    assert max(map(len, text.splitlines())) <= 120


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("veh_passenger", "car"),
        ("bike_bicycle", "bicycle"),
        ("MotorCycle", "motorcycle"),
        ("truck_trailer", "trailer-truck"),
    ],
)
def test_guesses_of_types(name, kind):
    guesses = TypeGuesses()
    assert name in guesses
    assert guesses[name].kind == kind
    assert list(guesses) == [name]
    assert "car" not in guesses
    assert "DEFAULT_VEHTYPE" not in guesses
