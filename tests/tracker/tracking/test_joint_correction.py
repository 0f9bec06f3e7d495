"""Update of all tracks in one batch, against the update of each track."""

import numpy as np

from luxloop.tracker.tracking.filter_bank import SelectedBank
from luxloop.tracker.tracking.filters import FilterConfig, initial_filters, motion
from luxloop.tracker.tracking.hypotheses import HypothesisConfig, hypothesise
from luxloop.tracker.tracking.joint_correction import update
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.track_arrays import predictions
from luxloop.tracker.tracking.track_observation import track_observation
from tests.support.mixed_traffic import assert_equal, mixed_traffic
from tests.support.one_track import CAR, CONFIG, DT, observe_boxes, start


def observations(tracks):
    """An observation of each track: a box near its place, for some with a jump or a truncated side."""
    found = []
    for k, track in enumerate(tracks):
        cut = (k % 3 == 1, False, False, k % 4 == 2)
        place = np.add([*track.footprint.center, track.heading], (0.1 * k, 1.5 * (k == 3), 0.01 * k))
        seen = observe_boxes(place, CAR, cut=cut)
        found.append(track_observation(hypothesise(predictions([track]), seen, HypothesisConfig()), seen, 0, 0))
    return found


def test_a_batch_updates_as_each_track_alone():
    """The batch contains the same operations on the same numbers, so that all bits agree."""
    together, alone = ([*mixed_traffic(), start((30.0, -3.5, 0.3))] for _ in range(2))
    for _ in range(3):
        for track in (*together, *alone):
            track.predict(motion(DT, FilterConfig()))
        seen = observations(alone)
        update(together, seen)
        for track, one in zip(alone, seen, strict=True):
            track.update(one)
    for one, other in zip(together, alone, strict=True):
        assert_equal(one, other)
        assert np.isfinite(one.corner.independent.nis).all()
        assert one.hits == other.hits


def test_a_bank_with_its_own_update_is_not_in_the_batch():
    class Counting(SelectedBank):
        calls = 0

        def observe(self, residual, noise):
            self.calls += 1
            return super().observe(residual, noise)

    own, other = start((20.0, 3.5, 0.0)), start((20.0, 3.5, 0.0))
    own.corner.bank = Counting(initial_filters(own.corner.position, np.eye(2), CONFIG.filters), MmaConfig())
    other.corner.bank = SelectedBank(initial_filters(own.corner.position, np.eye(2), CONFIG.filters), MmaConfig())
    seen = observations([own, other])
    update([own, other], [seen[0], seen[0]])
    assert own.corner.bank.calls == 1
    assert_equal(own, other)


def test_no_pairs_need_no_update():
    update([], [])
