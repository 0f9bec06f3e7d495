"""SUMO's floating car data: files written by SUMO, and invalid files."""

import gzip
from contextlib import closing

import numpy as np
import pytest
from support.paths import CATALOG

from luxloop.sim.replay.fcd import read_fcd
from luxloop.sim.replay.recording import ReplayType
from luxloop.sim.replay.trajectories import Trajectories
from luxloop.sim.source import TrafficInputError
from luxloop.sim.world import Kind

CROSSING = CATALOG / "urban" / "sumo-crossing"
WALKERS = """<routes><route id="east" edges="west_in east_out"/>
<vehicle id="first" route="east" depart="0" departPos="60" departLane="1" departSpeed="0"/>
<person id="rider" depart="triggered"><ride from="west_in" to="east_out" lines="first"/></person>
<person id="second" depart="0" departPos="55"><walk edges="west_in east_out"/></person>
<vehicle id="second" route="east" depart="1" departSpeed="0"/></routes>"""
TYPES = {
    "compact": ReplayType("car", (4.25, 1.8, 1.45)),
    "long": ReplayType("truck", (9.5, 2.5, 3.4)),
}


def simulate(folder, routes, seconds, *options):
    """Run SUMO with FCD output; return its front bumpers and angles by time and kind."""
    import libsumo

    (folder / "traffic.rou.xml").write_text(routes)
    command = ["sumo", "-n", str(CROSSING / "crossing.net.xml"), "-r", str(folder / "traffic.rou.xml")]
    command += ["--fcd-output", str(folder / "out.xml"), "--step-length", "0.08", "--seed", "3", "--no-warnings"]
    libsumo.start([*command, "--no-step-log", "--duration-log.disable", *options])
    written = {}
    with closing(libsumo):
        for _ in range(round(seconds / 0.08)):
            libsumo.simulationStep()
            # poses of a step are written with the time of its start
            time = libsumo.simulation.getTime() - 0.08
            for domain in (libsumo.vehicle, libsumo.person):
                for name in domain.getIDList():
                    place = (*domain.getPosition(name), domain.getAngle(name), domain.getLength(name))
                    written[round(time, 2), domain is libsumo.person, name] = place
    return written


ROUTES = """<routes><vType id="compact" length="4.25"/><vType id="long" length="9.5" maxSpeed="10"/>
<route id="s_n" edges="south_in north_out"/><route id="e_s" edges="east_in south_out"/>
<route id="w_s" edges="west_in south_out"/>
<flow id="a" type="compact" route="s_n" begin="0" end="20" period="2" departLane="random" departSpeed="max"/>
<flow id="b" type="long" route="e_s" begin="0" end="20" period="4" departPos="100" departSpeed="max"/>
<flow id="c" type="compact" route="w_s" begin="0" end="20" period="3" departPos="120" departSpeed="max"/></routes>"""


def test_a_round_trip_through_sumo_preserves_poses(tmp_path):
    """Detects bumpers used as centres, angles used as yaws, and interpolation that misses the samples."""
    written = simulate(tmp_path, ROUTES, 20.0, "--tls.all-off", "true")
    trajectories = Trajectories.of(read := read_fcd(tmp_path / "out.xml", TYPES), gap_s=1.0)
    assert len(trajectories.user) == len(read.users) > 15  # no trajectory is split
    turned = 0.0
    for (time, _, name), (x, y, angle, length) in written.items():
        yaw = np.pi / 2 - np.radians(angle)
        centre = np.array([x - length / 2 * np.cos(yaw), y - length / 2 * np.sin(yaw)])
        (trajectory,) = (row for row, user in enumerate(trajectories.user) if read.users[user].name == name)
        pose, _ = trajectories.at(np.array([trajectory]), time)
        assert pose[0, :2] == pytest.approx(centre, abs=0.02)
        assert np.cos(pose[0, 2] - yaw) == pytest.approx(1.0, abs=1e-6)
        turned = max(
            turned, np.ptp(trajectories.pose[trajectories.first[trajectory] : trajectories.last[trajectory] + 1, 2])
        )
    assert turned > 1.0, "no vehicle has turned a corner yet"
    kinds = {user.name[0]: (user.kind, user.size) for user in read.users}
    assert kinds["a"] == (Kind.CAR, (4.25, 1.8, 1.45))
    assert kinds["b"] == (Kind.TRUCK, (9.5, 2.5, 3.4))


@pytest.mark.parametrize("attributes", [(), ("--fcd-output.attributes", "all", "--precision", "4")])
def test_pedestrians_are_read_and_passengers_are_not(tmp_path, attributes):
    simulate(tmp_path, WALKERS, 4.0, *attributes)
    users = read_fcd(tmp_path / "out.xml", {}).users
    assert [(user.name, user.kind) for user in users] == [
        ("first", Kind.CAR),
        ("second", Kind.CAR),
        ("second", Kind.PEDESTRIAN),
    ]
    assert users[0].size == (5.0, 1.8, 1.5)  # SUMO's default


def test_files_may_be_compressed(tmp_path):
    simulate(tmp_path, WALKERS, 2.0)
    (tmp_path / "out.xml.gz").write_bytes(gzip.compress((tmp_path / "out.xml").read_bytes()))
    plain, packed = (read_fcd(tmp_path / name, {}) for name in ("out.xml", "out.xml.gz"))
    assert packed.users == plain.users
    assert np.array_equal(packed.pose, plain.pose)


STEP = """<fcd-export><timestep time="0.00"/><timestep time="0.08">
    <vehicle id="v" x="1.0" y="2.0" angle="90.0" type="DEFAULT_VEHTYPE" speed="1.0"/></timestep>
<timestep time="0.16"><vehicle id="v" x="1.1" y="2.0" angle="90.0" type="DEFAULT_VEHTYPE" speed="1.0"/></timestep>
</fcd-export>"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('type="DEFAULT_VEHTYPE"', 'type="tram"', 'type "tram" is neither in traffic.types nor a kind'),
        ('angle="90.0" ', "", 'vehicle "v" at 0.08 s: angle = ""; write x, y, angle and type'),
        ('x="1.1"', 'x="nan"', 'vehicle "v" at 0.16 s: x = "nan" is not a finite number'),
        ('time="0.16"', 'time="0:00:00.16"', 'timestep time = "0:00:00.16" should be seconds'),
        ('x="1.1"', 'x="1.0000009"', "x and y are degrees, not metres; write it without fcd-output.geo"),
        ("</fcd-export>", "", "not a complete XML file: no element found"),
        (STEP, "<fcd-export/>", "has no vehicle and no person"),
    ],
)
def test_invalid_files_are_errors_of_one_line(tmp_path, old, new, message):
    path = tmp_path / "a.xml"
    path.write_text(STEP.replace(old, new))
    with pytest.raises(TrafficInputError) as error:
        read_fcd(path, {})
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_an_absurd_position_warns_of_no_overflow(tmp_path, recwarn):
    """The replay refuses it by name later; a warning would be a second line on standard error."""
    path = tmp_path / "a.xml"
    path.write_text(STEP.replace('x="1.1"', 'x="1e308"'))
    read_fcd(path, {})
    assert [str(warning.message) for warning in recwarn] == []
