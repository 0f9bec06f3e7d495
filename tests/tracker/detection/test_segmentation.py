"""Segmentation, and preprocessing of single points."""

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from support import naive_fit
from support.shapes import Car, scan_car

from luxloop.tracker.detection import preprocess, segmentation
from luxloop.tracker.detection.preprocess import PreprocessConfig
from luxloop.tracker.detection.segmentation import SegmentationConfig
from luxloop.tracker.records import NOT_USED, Segments
from luxloop.tracker.scan import PointFlag, Scan


def segment(points, **config):
    return segmentation.segment(points, np.ones(len(points), bool), SegmentationConfig(**config))


def make_scan(points, flags=0, echo=0):
    count = len(points)
    return Scan(
        time=0.0,
        ego_pose_odom=np.zeros(3),
        points_ego=np.asarray(points, dtype=np.float32).reshape(-1, 3),
        time_offset=np.zeros(count, np.float32),
        unit=np.zeros(count, np.uint8),
        layer=np.zeros(count, np.uint8),
        echo=np.full(count, echo, np.uint8),
        echo_pulse_width=np.ones(count, np.float32),
        flags=np.full(count, flags, np.uint16),
    )


@given(arrays.arrays(float, st.tuples(st.integers(1, 60), st.just(2)), elements=st.floats(-6, 6, width=32)))
def test_components_equal_those_of_all_pairs(points):
    """A cell window that is too narrow, or the radius of the wrong point, loses a pair."""
    config = SegmentationConfig(radius_m=0.5, radius_per_m=0.1)
    radius = 0.5 + 0.1 * np.linalg.norm(points, axis=1)
    np.testing.assert_array_equal(segmentation.connect(points, config), naive_fit.connected(points, radius))


@given(st.floats(-50, 50), st.floats(-50, 50), st.sampled_from([*np.arange(0.0, 6.3, 0.1).tolist(), np.pi / 2, np.pi]))
def test_the_radius_is_exact_in_every_direction(x, y, angle):
    """Two points just inside or outside the radius, at any position of the cells."""
    step = np.array([np.cos(angle), np.sin(angle)])
    for reach, chains in ((0.499, 1), (0.501, 2)):
        pair = np.array([[x, y], [x, y] + reach * step])
        assert len(set(segmentation.connect(pair, SegmentationConfig(0.5, 0.0)))) == chains


def test_components_equal_those_of_a_kd_tree():
    """Zhang 2017 searches a KD-tree; the cells must find the same components in a full frame."""
    points = np.random.default_rng(3).uniform(-40, 40, (3000, 2))
    config = SegmentationConfig()
    radius = config.radius_m + config.radius_per_m * np.linalg.norm(points, axis=1)
    pairs = scipy.spatial.cKDTree(points).query_pairs(radius.max(), output_type="ndarray")
    gap = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    joined = pairs[gap <= np.maximum(radius[pairs[:, 0]], radius[pairs[:, 1]])]
    graph = scipy.sparse.coo_matrix((np.ones(len(joined)), joined.T), shape=(len(points), len(points)))
    count, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    ours = segmentation.connect(points, config)
    assert len(np.unique(ours)) == count
    assert len(np.unique(np.stack([ours, label]), axis=1).T) == count


def test_segments_are_numbered_by_their_first_point_and_small_ones_are_dropped():
    near, far, small = np.full((5, 2), 3.0), np.full((6, 2), -9.0), np.full((4, 2), 20.0)
    points = np.concatenate([small[:2], far[:1], near, far[1:], small[2:]])
    result = segment(points)
    assert result.count == 2
    np.testing.assert_array_equal(result.label, [NOT_USED] * 2 + [0] + [1] * 5 + [0] * 5 + [NOT_USED] * 2)


@pytest.mark.parametrize("distance", [8.0, 20.0, 35.0])
@pytest.mark.parametrize("gap", [(0.0, 1.5), (2.0, 0.0)], ids=["adjacent lane", "queue"])
def test_neighbouring_cars_stay_apart(distance, gap):
    """Lanes of 3.3 m leave 1.5 m between cars, queues 2 m: a radius that grows too fast merges them."""
    size = np.array([4.7, 1.8])
    first = np.array([distance, 2.5])
    second = first + (size + gap) * (np.array(gap) > 0)
    rng = np.random.default_rng(0)
    scans = [scan_car(Car(center=tuple(center), size=tuple(size)), rng)[0] for center in (first, second)]
    owner = np.repeat([0, 1], [len(scan) for scan in scans])
    label = segment(np.concatenate(scans)).label
    assert not set(label[owner == 0]) & set(label[owner == 1]) - {NOT_USED}


@pytest.mark.parametrize("heading", np.deg2rad([35.0, 50.0, 65.0]))
@pytest.mark.parametrize("distance", [10.0, 25.0, 40.0])
def test_a_car_with_mirrors_and_window_is_one_segment(heading, distance):
    car = Car(center=(distance, 3.0), heading=heading, mirrors=True, window_depth=1.0)
    points, _ = scan_car(car, np.random.default_rng(1))
    result = segment(points)
    assert result.count == 1
    assert np.mean(result.label == 0) > 0.95


def test_a_dense_cluster_needs_no_search_over_pairs():
    """A search over the 5 * 10^9 pairs of 10^5 points within one metre would not finish."""
    points = np.random.default_rng(0).normal(10.0, 0.2, (100_000, 2))
    segment(points[:10])
    assert segment(points).count == 1


@pytest.mark.parametrize(("points", "count"), [(np.empty((0, 2)), 0), ([[5.0, 5.0]], 0), (np.full((20, 2), 5.0), 1)])
def test_degenerate_scans(points, count):
    result = segment(np.asarray(points))
    assert result.count == count
    assert len(result.label) == len(points)


def test_dropped_points_connect_no_segments():
    """A dropped point between two objects must not connect them."""
    points = np.array([[10.0 + 0.5 * i, 0.0] for i in range(11)])
    keep = np.arange(11) != 5
    assert segmentation.segment(points, keep, SegmentationConfig(points_min=2)).count == 2
    assert segmentation.segment(points, keep, SegmentationConfig(points_min=2)).label[5] == NOT_USED


@pytest.mark.parametrize("values", [{"radius_m": 0.0}, {"radius_per_m": -0.1}, {"points_min": 1}])
def test_invalid_settings_are_rejected_by_name(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        SegmentationConfig(**values)


@pytest.mark.parametrize(
    ("point", "kept"),
    [
        ((20.0, 0.0, 0.5), True),
        ((20.0, 0.0, 0.1), False),  # ground
        ((61.0, 0.0, 0.5), False),  # out of range
        ((2.4, 0.9, 0.5), False),  # the ego's own corner
        ((2.4, 1.2, 0.5), True),  # beside the ego
        ((np.nan, 0.0, 0.5), False),
        ((5.0, np.inf, 0.5), False),
        ((5.0, 0.0, np.nan), False),
    ],
)
def test_keep_by_position(point, kept):
    assert preprocess.keep(make_scan([point]), PreprocessConfig()).tolist() == [kept]


def test_keep_by_flag_and_echo():
    point = [(20.0, 0.0, 0.5)]
    for flag in PointFlag:
        name = flag.name.lower()
        assert preprocess.keep(make_scan(point, flags=flag), PreprocessConfig())[0] == (name == "transparent")
        assert not preprocess.keep(make_scan(point, flags=flag), PreprocessConfig(drop_flags=(name,)))[0]
        assert preprocess.keep(make_scan(point, flags=flag), PreprocessConfig(drop_flags=()))[0]
    second = make_scan(point, echo=1)
    assert preprocess.keep(second, PreprocessConfig())[0]
    assert not preprocess.keep(second, PreprocessConfig(first_echo_only=True))[0]


def test_keep_of_an_empty_scan():
    assert preprocess.keep(make_scan([]), PreprocessConfig()).shape == (0,)


def test_an_unknown_flag_is_rejected():
    with pytest.raises(ValueError, match=r"rain.*choose from transparent"):
        PreprocessConfig(drop_flags=("rain",))


def random_segments(seed, count=60, segments=5):
    """Points (count, 3) with attributes, in segments or in none."""
    rng = np.random.default_rng(seed)
    label = rng.integers(-1, segments, count)
    columns = {"scan_line": rng.integers(0, 9, count), "time_offset": rng.normal(size=count),
               "viewpoints": rng.normal(size=(count, 2)), "truncated": rng.random(count) < 0.5}  # fmt: skip
    return rng.normal(size=(count, 3)), Segments(label, segments), columns


def equals_those_of_the_scan(found, points, segments, columns):
    """Every row is the point of its source; segments are in order, and their points in the order of the scan."""
    for s in range(segments.count):
        rows = slice(found.offset[s], found.offset[s + 1])
        assert found.source[rows].tolist() == np.flatnonzero(segments.label == s).tolist()
        assert set(found.label[rows]) <= {s}
    assert found.offset[-1] == len(found.source)
    own = found.xy, found.z, found.scan_line, found.time_offset, found.viewpoint_ego, found.truncated
    for mine, of_scan in zip(own, (points[:, :2], points[:, 2], *columns.values()), strict=True):
        np.testing.assert_array_equal(mine, of_scan[found.source])


@given(st.integers(0, 10_000))
def test_points_are_sorted_by_segment_in_the_order_of_the_scan(seed):
    points, segments, columns = random_segments(seed)
    found = segmentation.sort_by_segment(points, segments, **columns)
    equals_those_of_the_scan(found, points, segments, columns)
    xy, first = found.chosen(found.truncated)
    for s in range(segments.count):
        expected = points[(segments.label == s) & columns["truncated"], :2]
        np.testing.assert_array_equal(xy[first[s] : first[s + 1]], expected)


@given(st.integers(0, 10_000))
def test_points_sorted_again_are_those_of_the_other_segments(seed):
    """Points may leave a segment, and a segment may go."""
    points, segments, columns = random_segments(seed)
    fewer = np.where(points[:, 0] < 0.5, segments.label, NOT_USED)
    rest = segmentation.keep_only(Segments(fewer, segments.count), np.bincount(fewer[fewer >= 0], minlength=5) > 4)
    again = segmentation.regrouped(segmentation.sort_by_segment(points, segments, **columns), rest)
    equals_those_of_the_scan(again, points, rest, columns)


def test_unknown_attributes_of_points_have_defaults():
    found = segmentation.sort_by_segment(np.ones((3, 2)), Segments(np.array([0, -1, 0]), 1))
    assert found.z.tolist() == found.time_offset.tolist() == [0.0, 0.0]
    assert found.scan_line.tolist() == [0, 0]
    assert found.viewpoint_ego.tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert not found.truncated.any()
