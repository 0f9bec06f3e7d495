import dataclasses
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import chi2
from support.seen import corners, observe_boxes

from luxloop.tracker.tracking.association import AssociationConfig, assign, score
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, Predictions, hypothesise, shows_end

CONFIG, READING = AssociationConfig(), HypothesisConfig()
CAR = (4.6, 1.8)
CORNERS = [(1, 1), (1, -1), (-1, -1), (-1, 1)]


def expecting(pose, corner_sign, size=CAR, std_m=0.2, velocity=(0.0, 0.0)):
    """Prediction of a track of the given corner of a vehicle at `pose`."""
    return Predictions(
        position=corners(pose, size)[[CORNERS.index(corner_sign)]][None],
        velocity=np.array([[velocity]], dtype=float),
        covariance=np.eye(2)[None, None] * std_m**2,
        probability=np.ones((1, 1)),
        heading=np.array([pose[2]]),
        heading_variance=np.array([0.02**2]),
        size=np.array([size]),
        known_size=np.array([size]),
        whole=np.ones((1, 2), dtype=bool),
        corner_sign=np.array([corner_sign], dtype=np.int64),
    )


def associate(tracks, seen):
    """Pairs (track, box) of one round."""
    return assign(*score(tracks, hypothesise(tracks, seen, READING), seen, CONFIG))


@pytest.mark.parametrize(("known_length", "gated"), [(0.1, True), (11.4, False)])
def test_a_box_that_ends_at_the_tracked_end_corrects_an_uncertain_length(known_length, gated):
    """A lorry of assumed 11.4 m is tracked by its front, 6 m ahead of the ego; the box beside the ego is 7.8 m long."""
    track = dataclasses.replace(
        expecting((0.3, 4.0, 0.0), (1, -1), (11.4, 2.5)), known_size=np.array([[known_length, 2.5]])
    )
    seen = observe_boxes((2.1, 4.0, 0.0), (7.8, 2.5))
    hypotheses = hypothesise(track, seen, READING)
    assert seen.corner_sign[0, 0] == -1, "the rear of the box is the nearer end"
    assert hypotheses.end_visible[0, 0, 0] is np.bool_(not gated)
    assert bool(associate(track, seen)) is gated


def best_by_brute_force(cost, admissible):
    """Most pairs first, then the least total cost, over every pairing of rows and columns."""
    rows, columns = cost.shape
    ways = permutations(range(columns), rows) if rows <= columns else None
    if ways is None:
        return best_by_brute_force(cost.T, admissible.T)
    found = []
    for way in ways:
        chosen = [(r, c) for r, c in enumerate(way) if admissible[r, c]]
        found.append((-len(chosen), sum(cost[r, c] for r, c in chosen)))
    return min(found)


@given(st.data())
def test_assign_is_optimal(data):
    shape = data.draw(st.tuples(st.integers(1, 4), st.integers(1, 4)))
    cost = data.draw(arrays(float, shape, elements=st.floats(-20, 20, width=16)))
    admissible = data.draw(arrays(bool, shape))
    pairs = assign(cost, admissible)
    assert all(admissible[p] for p in pairs)
    assert len({t for t, _ in pairs}) == len({b for _, b in pairs}) == len(pairs)
    count, total = best_by_brute_force(cost, admissible)
    assert (-len(pairs), sum(cost[p] for p in pairs)) == (count, pytest.approx(total, abs=1e-6))


def test_pairs_outside_the_gate_are_rejected():
    tracks = expecting((10.0, 4.0, 0.1), (-1, -1))
    near, far = (10.3, 4.0, 0.1), (12.0, 4.0, 0.1)
    for pose, expected in ((near, [(0, 0)]), (far, [])):
        seen = observe_boxes(pose, CAR)
        assert associate(tracks, seen) == expected


@pytest.mark.parametrize(("outside", "pairs"), [(0.0011, [(0, 0)]), (0.0009, [])])
def test_the_gate_holds_999_of_1000_boxes_of_the_track(outside, pairs):
    """Squared distance at which this share of a chi-square with two degrees is outside."""
    tracks, pose = expecting((10.0, 4.0, 0.0), (-1, -1)), (10.0, 4.0, 0.0)
    covariance = hypothesise(tracks, observe_boxes(pose, CAR), READING).covariance[0, 0]
    variance = (covariance + tracks.covariance[0, 0])[0, 0] + CONFIG.view_std_m**2
    shift = np.sqrt(chi2.isf(outside, 2) * variance)
    assert associate(tracks, observe_boxes((10.0 + shift, 4.0, 0.0), CAR)) == pairs


@pytest.mark.parametrize("quarters", range(4))
def test_a_hypothesis_does_not_depend_on_the_quarter_turn_of_the_box(quarters):
    pose = (10.0, 4.0, 0.3)
    tracks = expecting(pose, (-1, -1))
    hypotheses = hypothesise(tracks, observe_boxes(pose, CAR, quarters=quarters), READING)
    assert hypotheses.heading[0, 0] == pytest.approx(0.3)
    assert hypotheses.size[0, 0] == pytest.approx(CAR)
    assert tuple(hypotheses.corner_sign[0, 0]) == (-1, -1)
    assert hypotheses.innovation[0, 0] == pytest.approx(np.zeros((1, 2)), abs=1e-9)


@pytest.mark.parametrize("cut_end", range(4))
@pytest.mark.parametrize("quarters", range(4))
def test_truncated_ends_turn_with_the_heading_of_the_box(quarters, cut_end):
    """A piece of a side, truncated at the front, left, rear or right: its nearer end is whole unless that one is."""
    pose, piece = (10.0, 4.0, 0.0), (2.0, 0.1)
    tracks = expecting(pose, (-1, -1))
    ends = [cut_end == (end + quarters) % 4 for end in range(4)]
    seen = observe_boxes((8.8, 3.2, 0.0), piece, quarters=quarters, cut=ends)
    hypotheses = hypothesise(tracks, seen, READING)
    assert hypotheses.untruncated[0, 0].tolist() == [cut_end % 2 == 1, cut_end % 2 == 0]
    assert hypotheses.end_visible[0, 0].tolist() == [cut_end == 0, True], (
        "the piece is long enough if its front is truncated"
    )


def test_a_new_nearest_corner_is_tracked_and_measures_the_old_one_by_the_known_size():
    """The car has passed: its front left is tracked, its rear left is now far nearer."""
    pose = (6.0, -3.0, 0.0)
    tracks = expecting(pose, (1, 1))
    hypotheses = hypothesise(tracks, observe_boxes((6.2, -3.1, 0.0), CAR), READING)
    assert tuple(hypotheses.corner_sign[0, 0]) == (-1, 1)
    assert hypotheses.innovation[0, 0, 0] == pytest.approx([0.2, -0.1])


@pytest.mark.parametrize(
    ("piece", "moved"),
    [
        ((5.0, -3.0), (0.0, 0.0)),  # anywhere within the side: the position along it is ambiguous
        ((4.0, -3.0), (0.0, 0.0)),
        ((3.2, -3.0), (-0.5, 0.0)),  # protrudes at the rear by 0.5 m
        ((6.8, -2.8), (0.5, 0.2)),  # protrudes at the front; the side is exact
    ],
)
def test_a_piece_of_a_side_corrects_the_track_only_by_its_protrusion(piece, moved):
    """A side 4.6 m long from x = 2.7 to 7.3, of which 2 m are visible."""
    tracks = expecting((5.0, -3.0, 0.0), (-1, 1))
    depth = 0.1
    seen = observe_boxes((piece[0], piece[1] + 0.9 - depth / 2, 0.0), (2.0, depth))
    seen = dataclasses.replace(seen, corner_sign=np.array([(-1, 1)]))
    hypotheses = hypothesise(tracks, seen, READING)
    assert hypotheses.innovation[0, 0] == pytest.approx(np.array([moved]), abs=1e-9)
    along, across = np.diag(hypotheses.covariance[0, 0]) - np.diag(seen.covariance[0])[:2]
    assert along == pytest.approx(READING.end_std_m**2)
    assert across == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("size", "cut", "shown"),
    [
        ((0.2, 1.8), (), (True, True)),  # a whole rear: its face, and both ends of it
        ((0.2, 1.0), (), (True, False)),  # an unknown part of a rear
        ((0.2, 1.0), ("left",), (True, True)),  # its left is hidden, so its right end is exact
        ((0.2, 1.0), ("right",), (True, False)),
        ((4.6, 1.8), ("front", "left"), (True, True)),  # visible faces are exact
    ],
)
def test_an_end_is_exact_if_its_face_is_visible_or_the_truncation_explained(size, cut, shown):
    """Seen from behind, on its right: the near corner is the rear right one."""
    flags = np.array([side in cut for side in ("front", "left", "rear", "right")])
    near = np.array([-1.0, -1.0])
    assert tuple(shows_end(np.array(size), near, flags, np.array(CAR))) == shown


def test_truncated_ends_rotate_with_the_heading():
    """The same box, described by each of its four headings; its left end is hidden."""
    pose = (10.0, 4.0, 0.3)
    tracks = expecting(pose, (-1, -1))
    for quarters in range(4):
        seen = observe_boxes(pose, CAR, quarters=quarters)
        cut = np.roll([False, True, False, False], -quarters)[None]
        hypotheses = hypothesise(tracks, dataclasses.replace(seen, cut=cut), READING)
        assert hypotheses.untruncated[0, 0].tolist() == [True, False]


def test_of_two_boxes_at_one_place_the_one_with_its_heading_and_size_is_chosen():
    tracks = expecting((10.0, 4.0, 0.0), (-1, -1))
    right, turned, long = (10.05, 4.0, 0.0), (10.0, 4.0, 0.6), (13.7, 4.0, 0.0)
    for other, size in ((turned, CAR), (long, (12.0, 1.8))):
        seen = observe_boxes([other, right], [size, CAR])
        assert associate(tracks, seen) == [(0, 1)]


def test_greedy_chooses_the_cheapest_pair_first():
    """Hand computed: the optimum is 2 + 3; the greedy choice 1 leads to 1 + 9."""
    cost, everything = np.array([[1.0, 2.0], [3.0, 9.0]]), np.ones((2, 2), dtype=bool)
    assert assign(cost, everything) == [(0, 1), (1, 0)]
    assert assign(cost, everything, "greedy") == [(0, 0), (1, 1)]
    assert assign(cost, np.array([[True, True], [True, False]]), "greedy") == [(0, 0)]


def test_the_tracked_corner_changes_with_hysteresis():
    """Straight ahead both rear corners are equally near: the track must not alternate between them."""
    pose = (12.0, 0.05, 0.0)
    tracks = expecting(pose, (-1, 1))
    hypotheses = hypothesise(tracks, observe_boxes(pose, CAR), READING)
    assert tuple(hypotheses.corner_sign[0, 0]) == (-1, 1)


def test_the_more_certain_track_wins_a_box_between_two():
    pose = (10.0, 4.0, 0.0)
    vague, sure = expecting(pose, (-1, -1), std_m=2.0), expecting((10.1, 4.0, 0.0), (-1, -1), std_m=0.1)
    both = Predictions(*(np.concatenate([getattr(vague, f), getattr(sure, f)]) for f in Predictions.__slots__))
    seen = observe_boxes(pose, CAR)
    assert associate(both, seen) == [(1, 0)]


def test_an_unlikely_model_opens_no_gate():
    """Only the gate of the third, uncertain model contains the box; it counts if that model is probable."""
    pose, reach = (10.0, 4.0, 0.0), (14.0, 4.0, 0.0)
    one = expecting(pose, (-1, -1))
    seen = observe_boxes(reach, CAR)
    for probability, expected in (((0.96, 0.02, 0.02), []), ((0.5, 0.3, 0.2), [(0, 0)])):
        tracks = Predictions(
            position=np.repeat(one.position, 3, axis=1),
            velocity=np.zeros((1, 3, 2)),
            covariance=np.array([0.1, 0.2, 3.0])[None, :, None, None] ** 2 * np.eye(2),
            probability=np.array([probability]),
            heading=one.heading,
            heading_variance=one.heading_variance,
            size=one.size,
            known_size=one.known_size,
            whole=one.whole,
            corner_sign=one.corner_sign,
        )
        assert associate(tracks, seen) == expected


def test_the_leading_end_of_a_car_behind_an_occluder_measures_its_motion():
    """First 1.2 m of a side are visible, then 1.8 m, and the truncated end is fixed: the car moved by 0.6 m."""
    tracks = dataclasses.replace(expecting((5.0, -3.0, 0.0), (1, 1)), known_size=np.array([(1.2, 0.1)]))
    front = 5.0 + CAR[0] / 2
    seen = observe_boxes((front - 1.2 + 0.9, -2.15, 0.0), (1.8, 0.1))
    seen = dataclasses.replace(seen, corner_sign=np.array([(1, 1)]))
    assert hypothesise(tracks, seen, READING).innovation[0, 0, 0] == pytest.approx([0.6, 0.0], abs=1e-9)


def test_a_box_inside_the_assumed_vehicle_is_in_the_gate_whatever_is_known():
    """1.2 m of a car's side were seen; now another part, 2.2 m farther ahead, is visible, truncated at both ends."""
    tracks = dataclasses.replace(expecting((5.0, -3.0, 0.0), (-1, 1)), known_size=np.array([(1.2, 0.1)]))
    for ahead, expected in ((2.2, [(0, 0)]), (5.0, [])):
        seen = observe_boxes((5.0 - CAR[0] / 2 + 0.6 + ahead, -2.15, 0.0), (1.2, 0.1))
        seen = dataclasses.replace(seen, cut=np.ones((1, 4), dtype=bool))
        assert associate(tracks, seen) == expected


def test_either_end_of_a_longer_box_may_be_that_of_the_vehicle():
    """The length, 3.4 m, is wrong: the box, 4.6 m, agrees with the tracked front but not with the rear."""
    short = (3.4, 1.8)
    tracks = expecting((10.0, 4.0, 0.0), (1, -1), size=short)
    seen = observe_boxes((10.0 - 0.6, 4.0, 0.0), CAR)
    assert associate(tracks, seen) == [(0, 0)]
    assert associate(tracks, observe_boxes((10.0 - 1.8, 4.0, 0.0), CAR)) == []


@pytest.mark.parametrize(("whole", "expected"), [(True, []), (False, [(0, 0)])])
def test_a_wall_is_no_car_that_was_seen_from_end_to_end(whole, expected):
    """A box of 15 m at the place of a car; of a vehicle that was never seen whole it may be the rest."""
    tracks = dataclasses.replace(expecting((10.0, 4.0, 0.0), (-1, -1)), whole=np.full((1, 2), whole))
    seen = observe_boxes((10.0 - CAR[0] / 2 + 7.5, 4.0, 0.0), (15.0, 1.8))
    assert associate(tracks, seen) == expected


def test_a_rotated_box_is_in_the_gate_of_a_visible_track_only():
    tracks = expecting((10.0, 4.0, 0.0), (-1, -1), std_m=1.0)
    seen = observe_boxes((10.0, 4.0, 0.6), CAR)
    hypotheses = hypothesise(tracks, seen, READING)
    for coasting, expected in ((False, True), (True, False)):
        _, inside = score(tracks, hypotheses, seen, CONFIG, np.array([coasting]))
        assert bool(inside[0, 0]) is expected
