"""Marks of boxes in bird's-eye pictures."""

import numpy as np
import pandas as pd
import pytest

from luxloop.scenarios.report.html.birdseye import draw_truth, to_canvas

CAR = {
    "x_world_m": 10.0, "y_world_m": 2.0, "yaw_world_rad": 0.0, "length_m": 4.0, "width_m": 2.0, "graded": True,
    "name": "car.1", "kind": "car",
}  # fmt: skip


@pytest.mark.parametrize(("yaw", "inner", "front"), [(0.0, 11.5, 12.0), (np.pi, 8.5, 8.0)])
def test_a_true_box_shows_its_front(yaw, inner, front):
    """A heading error of 180 degrees is visible: the wedge is at the front of the true box."""
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_truth(axes, pd.DataFrame([{**CAR, "yaw_world_rad": yaw}]), np.zeros(3))
    (drawn,) = axes.lines
    expected = to_canvas(np.array([[front, 3.0], [inner, 2.0], [front, 1.0]]))
    found = drawn.get_xydata()
    assert found[1] == pytest.approx(expected[1])
    assert np.sort(found[[0, 2]], axis=0) == pytest.approx(np.sort(expected[[0, 2]], axis=0))
