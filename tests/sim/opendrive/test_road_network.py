"""Geometry of OpenDRIVE roads against closed forms, and the links between them."""

import math

import numpy as np
import pytest
from scipy.special import fresnel
from support.real_data import real_file
from support.storyboards import lane, network, road, section

from luxloop.sim.opendrive.road_network import read_network
from luxloop.sim.source import TrafficInputError


def geometry(shape, length=100, s=0, x=0, y=0, heading=0):
    return f'<geometry s="{s}" x="{x}" y="{y}" hdg="{heading}" length="{length}">{shape}</geometry>'


def only_road(folder, shape, length=100, **place):
    return network(folder, road(geometry(shape, length, **place), length=length)).roads["1"]


def test_an_arc_is_a_circle(tmp_path):
    bend = only_road(tmp_path, '<arc curvature="0.01"/>', math.pi * 50)
    for s in (0.0, 10.0, 100.0, math.pi * 50):
        x, y, heading, curvature = bend.pose(s, 0.0)
        assert (x, y) == pytest.approx((100 * math.sin(s / 100), 100 - 100 * math.cos(s / 100)), abs=1e-9)
        assert heading == pytest.approx(s / 100)
        assert curvature == bend.curvature(s) == 0.01


def test_a_spiral_is_an_euler_spiral(tmp_path):
    """By Fresnel integrals: curvature s / a^2 gives x = a sqrt(pi) C(s / (a sqrt(pi))) (Abramowitz and Stegun, 7.3)."""
    scale = 50.0
    spiral = only_road(tmp_path, f'<spiral curvStart="0" curvEnd="{200 / scale**2}"/>', 200)
    for s in (5.0, 60.0, 200.0):
        sine, cosine = fresnel(s / (scale * math.sqrt(math.pi)))
        x, y, heading, _ = spiral.pose(s, 0.0)
        assert (x, y) == pytest.approx(
            (scale * math.sqrt(math.pi) * cosine, scale * math.sqrt(math.pi) * sine), abs=1e-9
        )
        assert heading == pytest.approx(s**2 / (2 * scale**2))


def test_cubic_curves_are_evaluated_by_their_parameter(tmp_path):
    cubic = '<paramPoly3 pRange="{}" aU="0" bU="{}" cU="0" dU="0" aV="0" bV="0" cV="{}" dV="0"/>'
    by_length = only_road(tmp_path, cubic.format("arcLength", 1, 0.001))
    x, y, heading, curvature = by_length.pose(50.0, 0.0)
    assert (x, y) == pytest.approx((50.0, 2.5))
    assert heading == pytest.approx(math.atan(0.1))
    assert curvature == pytest.approx(0.002 / 1.01**1.5)
    normalized = only_road(tmp_path, cubic.format("normalized", 100, 10))
    assert normalized.pose(50.0, 0.0)[:2] == pytest.approx((50.0, 2.5))
    poly = only_road(tmp_path, '<poly3 a="0" b="0.75" c="0" d="0"/>')
    assert poly.pose(50.0, 0.0)[:2] == pytest.approx((40.0, 30.0)), "poly3 is parametrised by u, not by arc length"


def test_a_geometry_is_turned_and_moved(tmp_path):
    line = only_road(tmp_path, "<line/>", x=10, y=20, heading=math.pi / 2)
    assert line.pose(5.0, 2.0)[:2] == pytest.approx((8.0, 25.0))


def test_lane_centres_are_sums_of_widths_and_the_offset_of_lane_0(tmp_path):
    widths = section(left=[lane(1, 3.0)], right=[lane(-1, (3.0, 0.01, 0, 0)), lane(-2, 4.0)])
    way = network(tmp_path, road(sections=widths, offset='<laneOffset s="0" a="0.5" b="0" c="0" d="0"/>')).roads["1"]
    assert way.centre(0.0, 1) == pytest.approx(2.0)
    assert way.centre(0.0, -1) == pytest.approx(-1.0)
    assert way.centre(100.0, -1) == pytest.approx(0.5 - 2.0)
    assert way.centre(100.0, -2) == pytest.approx(0.5 - 4.0 - 2.0)
    assert [way.lane_at(100.0, t) for t in (4.0, 1.0, -1.0, -5.0, -8.0)] == [None, 1, -1, -2, None]


@pytest.mark.parametrize(
    ("rule", "lane_id", "forward"), [("RHT", -1, 1), ("RHT", 1, -1), ("LHT", -1, -1), ("LHT", 1, 1)]
)
def test_the_traffic_rule_gives_the_direction_of_lanes(tmp_path, rule, lane_id, forward):
    assert network(tmp_path, road(rule=rule)).roads["1"].forward(lane_id) == forward


def test_the_nearest_road_is_found_on_a_bend(tmp_path):
    roads = network(tmp_path, road(geometry('<arc curvature="0.01"/>', 150), length=150))
    x, y, *_ = roads.roads["1"].pose(77.7, -3.0)
    found, s, t = roads.nearest(x, y)
    assert (found.id, s, t) == ("1", pytest.approx(77.7, abs=1e-6), pytest.approx(-3.0, abs=1e-6))


def test_a_junction_leads_straight_ahead(tmp_path):
    link = '<successor elementType="junction" elementId="9"/>'
    one = [lane(-1)]
    incoming = road(sections=section(right=one), link=link)
    left = road(geometry('<arc curvature="0.05"/>', 30, x=500), section(right=one), 30, "left")
    ahead = road(geometry("<line/>", 30, x=500), section(right=one), 30, "ahead")
    ways = "".join(
        f'<connection id="{n}" incomingRoad="1" connectingRoad="{name}" contactPoint="start">'
        '<laneLink from="-1" to="-1"/></connection>'
        for n, name in enumerate(("left", "ahead"))
    )
    roads = network(tmp_path, incoming, left, ahead, f'<junction id="9">{ways}</junction>')
    following = roads.next_lane(roads.roads["1"], -1, 1)
    assert (following.road.id, following.lane, following.forward) == ("ahead", -1, 1)
    assert roads.next_lane(roads.roads["ahead"], -1, 1) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<OpenDRIVE/>", "line 1: <OpenDRIVE> has no <road>; add one"),
        ("<net/>", "its root is <net>; it should be <OpenDRIVE>"),
        ("<OpenDRIVE>", "not a complete XML file"),
        ('<?xml version="1.0" encoding="UTF9"?><OpenDRIVE/>', "not a complete XML file: unknown encoding: UTF9"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><OpenDRIVE/>', "has a document type declaration"),
        (f"<OpenDRIVE>{road(geometry('<bezier/>'))}</OpenDRIVE>", "<bezier> of .* is no geometry; use line, arc"),
        (f"<OpenDRIVE>{road(geometry('<arc/>'))}</OpenDRIVE>", 'has no attribute "curvature"; add it'),
        (f"<OpenDRIVE>{road(geometry('<line/>', 'nan'))}</OpenDRIVE>", 'length = "nan" should be a number'),
        ("<OpenDRIVE>" + "<a>" * 300 + "</a>" * 300 + "</OpenDRIVE>", "nested more than 200 levels"),
    ],
)
def test_invalid_files_are_refused_in_one_line(tmp_path, text, message):
    path = tmp_path / "a.xodr"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(TrafficInputError, match=message.replace("<bezier> of .*", "<bezier>")) as error:
        read_network(path)
    assert str(error.value).startswith("a.xodr")
    assert "\n" not in str(error.value)


def test_the_bend_of_a_public_example_has_a_radius_of_100_m():
    """`curve_r100.xodr`: 500 m straight, a quarter of a circle of 100 m, 100 m straight; lanes of 3.07 m."""
    bend = read_network(real_file("openscenario/xodr/curve_r100.xodr")).roads["0"]
    t = bend.centre(550.0, -1)
    assert t == pytest.approx(-1.535)
    points = np.array([bend.pose(s, t)[:2] for s in np.linspace(500.0, 500 + 50 * math.pi, 50)])
    assert np.hypot(*(points - (500.0, 100.0)).T) == pytest.approx(101.535, abs=1e-6)
    assert bend.pose(700.0, t)[:3] == pytest.approx((601.535, 142.92037, math.pi / 2), abs=1e-5)


def test_the_geometries_of_public_examples_are_continuous():
    for name in ("e6mini", "soderleden", "straight_500m", "curve_r100"):
        for way in read_network(real_file(f"openscenario/xodr/{name}.xodr")).roads.values():
            for one in way.geometries[1:]:
                before, after = way.pose(one.s - 1e-7, 0.0), way.pose(one.s, 0.0)
                assert math.dist(before[:2], after[:2]) < 0.01, (name, way.id, one.s)
                assert abs(math.remainder(before[2] - after[2], 2 * math.pi)) < 0.01
