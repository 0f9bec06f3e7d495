"""Place of a stop beside the road, relative to the lane of the vehicle, in a bend by hand."""

from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from luxloop.sim.sumo.roadside_stops import TAPER, RoadsideStops

SHAPES = {"bend_1": [(0, 0), (50, 0), (50, 100)], "bend_0": [(0, -3.2), (53.2, -3.2), (53.2, 100)]}
"""Two lanes that turn left by 90 degrees; by the net they are half as long."""
STOP = SimpleNamespace(lane="bend_1", endPos=50.0, stopFlags=1)


def test_a_stop_in_a_bend_is_measured_along_the_outermost_lane():
    """50 m of 75 m are 100 m of a shape of 150 m: (50, 50) on the lane, and (56.4, 37.2) beside the outermost one."""
    calls = {"getStops": [STOP], "getLength": 5.0, "isStoppedParking": False, "getDrivingDistance": 1.0}
    vehicle = Mock(**{f"{name}.return_value": value for name, value in calls.items()})
    lane = Mock(**{"getShape.side_effect": SHAPES.__getitem__, "getLength.return_value": 75.0})
    stops = RoadsideStops(Mock(vehicle=vehicle, lane=lane), 1.0, left_hand=False)
    assert stops.shifts({"car": TAPER * 6.4})["car"] == pytest.approx((37.2 - 50.0, -6.4))
