"""Records of trackers without motion models."""

import numpy as np
import pytest

from luxloop.tracker.records import NO_MODEL, Status, Tracks

GIVEN = {"id": [3, 8], "center": [[1.0, 2.0], [-4.0, 0.5]], "heading": [0.1, 2.0], "size": [[4.5, 1.8], [8.0, 2.5]]}


def test_the_centres_are_those_given_and_the_rest_is_unknown():
    tracks = Tracks.from_boxes(**GIVEN)
    assert tracks.id.tolist() == [3, 8]
    assert tracks.center_odom.tolist() == GIVEN["center"]
    assert tracks.mean[:, 6].tolist() == GIVEN["heading"]
    assert tracks.size.tolist() == GIVEN["size"]
    assert tracks.status.tolist() == [Status.CONFIRMED] * 2
    assert tracks.model.tolist() == [NO_MODEL] * 2
    unknown = (tracks.mean[:, [2, 3, 4, 5, 7]], tracks.covariance, tracks.model_probability, tracks.model_position_odom)
    assert all(np.isnan(values).all() for values in unknown)


def test_motion_is_placed_in_its_columns():
    tracks = Tracks.from_boxes(
        **GIVEN, velocity=[[5.0, 6.0], [np.nan, np.nan]], acceleration=[0.5, -0.5], yaw_rate=0.2, status=[0, 2]
    )
    assert tracks.mean[0].tolist() == [1.0, 2.0, 5.0, 6.0, 0.5, -0.5, 0.1, 0.2]
    assert np.isnan(tracks.mean[1, 2:4]).all()
    assert tracks.status.tolist() == [Status.TENTATIVE, Status.COASTING]


def test_one_row_stands_for_all_tracks_and_none_is_empty():
    tracks = Tracks.from_boxes([1, 2], GIVEN["center"], 0.3, (4.5, 1.8))
    assert tracks.size.tolist() == [[4.5, 1.8]] * 2
    assert tracks.mean[:, 6].tolist() == [0.3, 0.3]
    assert len(Tracks.from_boxes([], [], [], [])) == 0


def test_the_record_does_not_share_memory_with_the_arguments():
    size = np.array(GIVEN["size"])
    tracks = Tracks.from_boxes(**GIVEN | {"size": size})
    size[:] = 0.0
    assert tracks.size.tolist() == GIVEN["size"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"center": [[0.0, 0.0]]}, r"center has shape \(1, 2\); give \(2, 2\), one row for each of the 2 tracks"),
        ({"heading": [0.0, 0.0, 0.0]}, r"heading has shape \(3,\); give \(2,\)"),
        ({"size": [4.0]}, r"size has shape \(1,\); give \(2, 2\)"),
        ({"velocity": 3.0}, r"velocity has shape \(\); give \(2, 2\)"),
        ({"id": [1.0, 2.0]}, "id holds float64; give one integer per track"),
    ],
)
def test_wrong_shapes_are_refused_by_name(change, message):
    with pytest.raises(ValueError, match=message):
        Tracks.from_boxes(**GIVEN | change)
