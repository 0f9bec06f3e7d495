"""Roadside obstacles: sizes and positions of their prisms."""

import math
from itertools import pairwise
from typing import get_args

import numpy as np
import pytest
from shapely.geometry import LineString, Point, Polygon

from luxloop.sim.obstacles import DEFAULTS, POST_SIZE, StreetKind, build, obstacles

LINE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 0.0], [16.0, 8.0]])
"""Two straights of 10 m, with a duplicate point."""
RAIL_TOP, BEAM, SPACING = 0.787, 0.312, 1.905  # [m], MGS guard rail: MwRSF 2010, AASHTO M 180


def polygons(prisms):
    return [Polygon(prism.corners) for prism in prisms]


@pytest.mark.parametrize("kind", get_args(StreetKind))
def test_every_kind_has_defaults_that_can_be_overridden(kind):
    points = LINE if DEFAULTS[kind].form == "line" else np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]])
    default = build(kind, points)
    assert max(prism.height for prism in default) == DEFAULTS[kind].height
    custom = build(kind, points, height=3.0, reflectivity=0.7)
    assert max(prism.height for prism in custom) == 3.0
    assert {prism.reflectivity for prism in custom} == {0.7}
    assert all(0.0 <= prism.base < prism.height for prism in [*default, *custom])


def test_a_building_is_one_outline_and_a_wall_one_face_per_segment():
    outline = LINE[[0, 1, 3]]
    (house,) = build("building", outline)
    assert np.array_equal(house.corners, outline)
    wall = build("wall", outline, height=2.0, base=0.5)
    assert [prism.corners.tolist() for prism in wall] == [[[0, 0], [10, 0]], [[10, 0], [16, 8]]]  # not closed
    assert {(prism.base, prism.height) for prism in wall} == {(0.5, 2.0)}


def test_the_mean_width_of_a_pole_is_its_diameter():
    first, second = build("pole", np.array([[3.0, 4.0], [8.0, 4.0]]), diameter=0.3)
    angle = np.linspace(0, 2 * np.pi, 721)[:-1]
    widths = np.ptp(first.corners @ np.array([np.cos(angle), np.sin(angle)]), axis=0)
    assert widths.mean() == pytest.approx(0.3, rel=1e-4)
    assert np.ptp(widths) < 0.03
    shape = Polygon(first.corners)
    assert shape.is_valid
    assert shape.area == pytest.approx(math.pi * 0.15**2, rel=0.06)
    assert shape.centroid.distance(Point(3.0, 4.0)) < 1e-9
    assert second.corners == pytest.approx(first.corners + np.array([5.0, 0.0]))


def test_a_guard_rail_is_a_beam_on_posts():
    prisms = build("guard-rail", LINE)
    beam = [prism for prism in prisms if prism.height == RAIL_TOP]
    posts = [prism for prism in prisms if prism.height != RAIL_TOP]
    assert all(prism.base == pytest.approx(RAIL_TOP - BEAM) for prism in beam)
    assert all((post.base, post.height) == (0.0, prisms[0].base) for post in posts), (
        "posts should end at the lower edge of the beam"
    )
    assert [prism.corners.tolist() for prism in beam] == [[[0, 0], [10, 0]], [[10, 0], [16, 8]]]
    line = LineString(LINE)
    middles = [Point(post.corners.mean(axis=0)) for post in posts]
    assert all(line.distance(middle) < 1e-9 for middle in middles)
    along = np.array([line.project(middle) for middle in middles])
    assert along == pytest.approx(SPACING * np.arange(11))  # the eleventh at 19.05 m of 20
    for post in posts:
        sides = np.hypot(*np.diff(post.corners, axis=0).T)
        assert sides == pytest.approx([POST_SIZE[0], POST_SIZE[1], POST_SIZE[0]])
    assert posts[-1].corners[0] - posts[-1].corners[1] == pytest.approx(POST_SIZE[0] * np.array([0.6, 0.8]))


def test_a_low_rail_has_no_posts():
    assert [(prism.base, prism.height) for prism in build("guard-rail", LINE[:2], height=0.3)] == [(0.0, 0.3)]


def test_prisms_are_converted_to_the_world_record():
    prisms = [*build("wall", LINE[:2], base=0.3), *build("tree", np.array([[1.0, 2.0]]))]
    world = obstacles(prisms)
    assert list(world.offset) == [0, 2, 10]
    assert list(world.base) == [0.3, 0.0]
    assert list(world.height) == [2.0, 4.0]
    for (first, last), prism in zip(pairwise(world.offset), prisms, strict=True):
        assert np.array_equal(world.vertices_world[first:last], prism.corners)
    assert len(obstacles([])) == 0


@pytest.mark.parametrize(
    ("kind", "points", "sizes"),
    [
        ("building", 1, {}),
        ("guard-rail", 1, {}),
        ("fence", 0, {}),
        ("pole", 0, {}),
        ("wall", 2, {"height": 0.0}),
        ("wall", 2, {"height": math.nan}),
        ("wall", 2, {"height": math.inf}),
        ("wall", 2, {"base": 2.0}),
        ("wall", 2, {"base": -0.1}),
        ("tree", 1, {"diameter": 0.0}),
        ("tree", 1, {"reflectivity": 1.1}),
    ],
)
def test_impossible_things(kind, points, sizes):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        build(kind, LINE[:points], **sizes)
