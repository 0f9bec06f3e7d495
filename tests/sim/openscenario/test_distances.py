"""Free space between bodies of different lengths ahead of and behind their reference points."""

from types import SimpleNamespace

import pytest

from luxloop.sim.openscenario.distances import free_space


def body(front, rear):
    return SimpleNamespace(entity=SimpleNamespace(front=front, rear=rear))


CAR, TRUCK = body(3.7, -0.8), body(5.0, -4.0)


@pytest.mark.parametrize(
    ("one", "other", "ahead", "gap"),
    [
        (CAR, TRUCK, 20.0, 20.0 - 4.0 - 3.7),
        (TRUCK, CAR, 20.0, 20.0 - 0.8 - 5.0),
        (CAR, TRUCK, -20.0, -(20.0 - 5.0 - 0.8)),
        (TRUCK, CAR, -20.0, -(20.0 - 3.7 - 4.0)),
        (CAR, TRUCK, 7.0, 0.0),
        (CAR, TRUCK, -5.0, 0.0),
    ],
)
def test_free_space_is_between_the_ends_that_face_each_other(one, other, ahead, gap):
    assert free_space(one, other, ahead) == pytest.approx(gap)
