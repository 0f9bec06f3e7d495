"""Trams and trains: number of sections, motion along rails against circle geometry, bodies, grading, and SUMO."""

import math
import xml.etree.ElementTree as ET
from contextlib import closing

import numpy as np
import pytest
import shapely
from support.frames import Body, Estimate, Scripted, grade_run
from support.naive_labels import straight
from support.paths import NETS
from support.sensor_scenes import ActorSpec, world
from support.solid_mesh import corners, pieces

from luxloop.scenarios.grading.articulated import parts
from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.scene import BodyFactory
from luxloop.sim.kinematics import RawFrame
from luxloop.sim.physical.layer import PhysicalTruth
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.roster import EGO_ID, Member
from luxloop.sim.sections import bend, section_count
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource
from luxloop.sim.world import JOINTS, Kind

BUS = np.array([Kind.BUS], np.uint8)
DT, SPEED, STRAIGHT = 0.04, 6.0, 40.0
SIZE = (2.4, 3.4)


def test_trams_have_the_sections_of_their_models_and_trains_cars_of_18_to_25_m():
    """Flexity Berlin: 30.8 m with 5 sections, 40.05 m with 7. Class 481: 3 units of 36.8 m, 2 cars. ICE 3: 8."""
    lengths = np.array([12.0, 18.125, 22.0, 30.8, 40.05, 110.4, 200.0, 400.0])
    assert section_count(np.repeat(BUS, len(lengths)), lengths).tolist() == [1, 2, 4, 5, 7, 6, 8, 8]
    others = np.array([Kind.TRUCK, Kind.TRAILER_TRUCK, Kind.CAR], np.uint8)
    assert section_count(others, np.full(3, 22.0)).tolist() == [1, 2, 1]


# ---- motion


def rails(along, radius):
    """Point of a straight track that becomes an arc to the left."""
    turn = max(along - STRAIGHT, 0.0) / radius
    return np.array([min(along, STRAIGHT) + radius * math.sin(turn), radius * (1 - math.cos(turn))])


def driven(length, radius, frames, start=0.0, stop=math.inf, member_id=1):
    """Motions of a tram, given as SUMO does: its front on the rails, its yaw along the line to its rear."""
    tram = Member(member_id, "tram", Kind.BUS, (length, *SIZE), 0.5)
    raw = []
    for k in range(frames):
        front, rear = (rails(min(start + SPEED * DT * k, stop) - behind, radius) for behind in (0.0, length))
        yaw = math.atan2(*(front - rear)[::-1])
        centre = front - 0.5 * length * np.array([math.cos(yaw), math.sin(yaw)])
        raw.append(RawFrame([tram], np.array([[*centre, yaw]]), np.array([SPEED * (start + SPEED * DT * k < stop)])))
    return settled(raw)


def settled(raw):
    """Motions after smoothing, without those of the last frames, which wait for their successors."""
    layer, out = PhysicalTruth(DT, PhysicalConfig(smoothing_s=0.3), rolling=True), []
    for frame in raw:
        layer.push(frame)
        while (ready := layer.pop()) is not None:
            out.append(ready[1])
    return out


def boxes(motion, length):
    """Pose (S, 3) and length (S,) of the sections, by the function that grades them."""
    _, pose, size = parts(motion.pose_world, np.array([[length, SIZE[0]]]), motion.joint_angles, BUS)
    return pose, size[:, 0]


def ends(pose, length):
    half = 0.5 * length[:, None] * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
    return np.concatenate([pose[:, :2] + half, pose[:, :2] - half])


@pytest.mark.parametrize(("length", "radius", "count"), [(22.0, 25.0, 4), (30.0, 20.0, 5), (110.4, 300.0, 6)])
def test_on_an_arc_the_sections_are_equal_chords_of_it(length, radius, count):
    """Chords of length c turn by 2 asin(c / 2R) from one to the next; their middles are on sqrt(R^2 - c^2 / 4)."""
    motion = driven(length, radius, round((STRAIGHT + 1.3 * length + 30.0) / SPEED / DT))[-1]
    chord, centre = length / count, (STRAIGHT, radius)
    turn = 2 * math.asin(0.5 * chord / radius)
    assert motion.joint_angles[0, : count - 1] == pytest.approx(np.full(count - 1, turn), abs=0.002)
    assert not motion.joint_angles[0, count - 1 :].any()
    pose, lengths = boxes(motion, length)
    assert lengths == pytest.approx(np.full(count, chord))
    assert np.hypot(*(ends(pose, lengths) - centre).T) == pytest.approx(np.full(2 * count, radius), abs=0.05)
    middles = np.hypot(*(pose[:, :2] - centre).T)
    assert middles == pytest.approx(np.full(count, math.sqrt(radius**2 - 0.25 * chord**2)), abs=0.05)


def test_on_a_straight_track_a_tram_is_one_rigid_body():
    for k, motion in enumerate(driven(22.0, 25.0, 140)):
        assert np.abs(motion.joint_angles).max() < 1e-9
        assert motion.pose_world[0] == pytest.approx([SPEED * DT * k - 11.0, 0.0, 0.0], abs=0.02)
        assert motion.velocity_world[0] == pytest.approx([SPEED, 0.0], abs=0.05)


def test_a_tram_that_is_moved_elsewhere_is_straight_there_at_once():
    """SUMO moves a vehicle that is stuck; the path behind it is that of the new place."""
    raw = []
    for k in range(200):
        tram = Member(1, "tram", Kind.BUS, (22.0, *SIZE), 0.5, stretch=int(k >= 100))
        pose = np.array([[SPEED * DT * k, 200.0 * (k >= 100), 0.0]])
        raw.append(RawFrame([tram], pose, np.array([SPEED])))
    motions = settled(raw)
    assert len(motions) > 110
    for k, motion in enumerate(motions):
        assert np.abs(motion.joint_angles).max() < 1e-9
        assert motion.pose_world[0] == pytest.approx([SPEED * DT * k, 200.0 * (k >= 100), 0.0], abs=0.02)


@pytest.mark.parametrize("length", [22.0, 30.0])
def test_rates_are_the_derivatives_of_the_poses_on_the_way_into_an_arc(length):
    motions = driven(length, 25.0, 500)[60:]  # beyond the transient of its start
    pose, velocity, acceleration = (
        np.array([getattr(motion, name)[0] for motion in motions])
        for name in ("pose_world", "velocity_world", "acceleration_world")
    )
    rate = np.array([motion.yaw_rate[0] for motion in motions])
    assert bend(np.vstack([motion.joint_angles for motion in motions])).max() > 0.5
    assert np.abs((pose[2:, :2] - pose[:-2, :2]) / (2 * DT) - velocity[1:-1]).max() < 0.01
    assert np.abs((velocity[2:] - velocity[:-2]) / (2 * DT) - acceleration[1:-1]).max() < 0.1  # of 1.44
    assert np.abs((pose[2:, 2] - pose[:-2, 2]) / (2 * DT) - rate[1:-1]).max() < 0.003


def test_a_tram_that_appears_on_an_arc_is_bent_from_its_first_frame():
    """The simulator's yaw, along the chord, and the course of the front define the arc."""
    motion = driven(22.0, 40.0, 80, start=STRAIGHT + 30.0)[0]
    assert motion.joint_angles[0, :3] == pytest.approx(np.full(3, 2 * math.asin(0.5 * 5.5 / 40.0)), abs=0.02)


def test_a_tram_that_stops_on_an_arc_is_exactly_still():
    motions = driven(22.0, 25.0, 700, stop=STRAIGHT + 30.0)
    still = motions[-60:]
    assert bend(still[0].joint_angles)[0] > 0.5
    for motion in still:
        assert np.array_equal(motion.pose_world, still[0].pose_world)
        assert np.array_equal(motion.joint_angles, still[0].joint_angles)
        assert not np.hstack([motion.velocity_world, motion.acceleration_world]).any()
        assert not motion.yaw_rate.any()


def test_a_tram_as_the_ego_stays_rigid():
    """The ego record has no angles."""
    assert not any(motion.joint_angles.any() for motion in driven(22.0, 25.0, 400, member_id=EGO_ID))


# ---- bodies


BENT = (0.2, (0.25, -0.1, 0.3, 0.0, 0.0, 0.0))
"""Angles at the joints of a tram of 30 m with five sections."""


def tram(first, further, *, plain, seed=None):
    spec = ActorSpec(0.0, 0.0, 0.0, Kind.BUS, articulation=first, further_articulation=further, size=(30.0, *SIZE))
    return BodyFactory(mirrors=False, plain=plain, glass=Glass(), seed=seed).place(world(spec))


def test_the_prisms_of_a_bent_tram_are_the_boxes_that_are_graded():
    bodies = tram(*BENT, plain=True)
    _, pose, size = parts(np.zeros((1, 3)), np.array([[30.0, SIZE[0]]]), np.array([[BENT[0], *BENT[1]]]), BUS)
    assert sorted(pose[:, 2]) == pytest.approx(sorted([0.45, 0.25, 0.0, 0.1, -0.2]))
    prisms = [shapely.MultiPoint(corners(piece.planes)[:, :2]).convex_hull for piece in pieces(bodies, 0)]
    for x, y, yaw, length, width in np.hstack([pose, size]):
        cos, sin = 0.5 * np.array([math.cos(yaw), math.sin(yaw)])
        along, across = length * np.array([cos, sin]), width * np.array([-sin, cos])
        box = shapely.Polygon([(x, y) + a * along + b * across for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
        assert min(box.symmetric_difference(prism).area for prism in prisms) < 1e-6


@pytest.mark.parametrize("seed", [None, 3])
def test_echoes_of_a_bent_tram_are_labelled_on_the_straight_one(seed):
    before, after = tram(0.0, (0.0,) * 6, plain=False, seed=seed), tram(*BENT, plain=False, seed=seed)
    first, moved = 0, 0
    for old, new in zip(pieces(before, 0), pieces(after, 0), strict=True):
        back = np.array([straight(after, first, point) for point in corners(new.planes)])
        first += len(old.planes)
        wanted = corners(old.planes)[:, :2]
        assert np.abs(back[:, None] - wanted).max(axis=2).min(axis=1).max() < 1e-6
        assert np.all(corners(new.planes) >= new.bounds[0] - 1e-6)
        assert np.all(corners(new.planes) <= new.bounds[1] + 1e-6)
        moved += not np.allclose(old.planes, new.planes)
    assert 0 < moved < first


# ---- grading


def test_a_track_on_one_section_of_a_bent_tram_follows_it():
    """Fails if the tram is graded as one straight box, which the track's box overlaps by less than a fifth."""
    body = Body(0, 0.0, 12.0, 0.0, size=(30.0, *SIZE), kind=Kind.BUS, articulation=0.3, further_articulation=(0.3,) * 6)
    row, pose, size = parts(np.array([[0.0, 12.0, 0.0]]), np.array([[30.0, SIZE[0]]]), np.full((1, JOINTS), 0.3), BUS)
    assert row.tolist() == [0] * 5
    front = Estimate(4, *pose[-1], size=tuple(size[-1]))
    metrics, tables, _ = grade_run([[body]] * 10, Scripted([[front]] * 10))
    assert set(tables["tracks"].verdict) == {"graded"}
    assert metrics["track.missed"].value == 0
    assert tables["truth"].articulation_5_rad.iloc[0] == pytest.approx(0.3)


# ---- SUMO


def test_sumo_s_trams_follow_their_lane_through_curves(tmp_path):
    """Ends of sections are where the front was, near the lane's middle, which a rigid box leaves; twice the same."""
    (tmp_path / "t.rou.xml").write_text(
        '<routes><vType id="t" vClass="tram" length="30" sigma="0" speedDev="0"/><vType id="car" sigma="0"/>'
        '<trip id="tram" type="t" depart="0" departPos="last" from="r20" to="hairpin"/>'
        '<trip id="ego" type="car" depart="5" from="r20" to="hairpin"/></routes>'
    )
    net = NETS / "winding/winding.net.xml"
    lanes = [
        shapely.LineString([[float(value) for value in point.split(",")[:2]] for point in lane.get("shape").split()])
        for lane in ET.parse(net).iter("lane")
    ]
    config = SumoTraffic(net=str(net), routes=["t.rou.xml"], ego="vehicle:ego")
    runs = []
    for _ in range(2):
        frames = []
        with closing(SumoSource(config, tmp_path, 300.0)) as source:
            source.reset(1)
            for _ in range(600):
                actors = source.step().actors
                if "tram" not in actors.name:
                    break
                frames.append(np.concatenate([actors.pose_world[0], actors.joint_angles[0]]))
                assert np.hypot(*actors.acceleration_world[0]) < 10.0
        runs.append(np.array(frames))
    assert np.array_equal(*runs)
    poses, bends = runs[0][:, :3], runs[0][:, 3:]
    assert bend(bends).max() > 0.5
    size = np.tile([30.0, SIZE[0]], (len(poses), 1))
    row, section_pose, section_size = parts(poses, size, bends, np.repeat(BUS, len(poses)))
    front, rear = np.split(ends(section_pose, section_size[:, 0]), 2)
    leads = np.array([np.flatnonzero(row == frame)[-1] for frame in range(len(poses))])  # the front section comes last
    driven_path = shapely.LineString(front[leads])
    later = np.hypot(*(front[leads] - front[leads[0]]).T)[row] > 40.0  # since when it has driven more than its length
    assert shapely.distance(shapely.points(rear[later]), driven_path).max() < 0.02
    tracks = shapely.union_all(lanes)
    off = shapely.distance(shapely.points(np.concatenate([front[later], rear[later]])), tracks)
    rigid = shapely.distance(shapely.points(ends(poses, size[:, 0])), tracks)
    assert off.max() < 0.65  # the front's path is smoothed, which cuts the corners of the lanes by as much
    assert np.quantile(rigid, 0.9) > 0.8
