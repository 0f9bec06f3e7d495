"""Stub trackers with one known fault each in the real run loop: only the expected metrics change, by known amounts.

Expected values follow from the truth alone: graded frames, speeds and sizes. N is the number of graded vehicle-frames.
"""

import math
from functools import partial

import numpy as np
import pytest
from support import shared_scans, short_run
from support.few import few
from support.many_metrics import METRICS, STANDARD
from support.stub_trackers import BiasedYaw, Forgetful, GhostMaking, IdSwapping, OneFrameLate, Perfect

from luxloop.scenarios.files import shipped
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.run import loop

DT = 0.08
STREET = """\
description = "A truck beside the ego hides a passing car for a while; one car is ahead, one oncoming, one parked."
duration_s = 5.6
[traffic]
kind = "scripted"
[traffic.ego]
motion = [{ kind = "straight", speed_mps = 6.0 }]
[[traffic.actor]]
name = "truck"
kind = "truck"
x_m = 1.0
y_m = 3.5
motion = [{ kind = "straight", speed_mps = 6.0 }]
[[traffic.actor]]
name = "hidden"
x_m = -22.0
y_m = 7.0
motion = [{ kind = "straight", speed_mps = 14.0 }]
[[traffic.actor]]
name = "ahead"
x_m = 18.0
y_m = 0.0
motion = [{ kind = "straight", speed_mps = 7.0 }]
[[traffic.actor]]
name = "oncoming"
x_m = 60.0
y_m = -4.0
yaw_deg = 180.0
motion = [{ kind = "straight", speed_mps = 8.0 }]
[[traffic.actor]]
name = "parked"
x_m = 30.0
y_m = -8.0
yaw_deg = 20.0
"""


class GradedRun:
    """Truth tables and metrics of a run."""

    def __init__(self, result):
        self.value = {name: result.metrics[name].value for name in METRICS}
        self.truth = result.tables["truth"]
        self.tracks = result.tables["tracks"]
        self.graded = self.truth[self.truth["graded"]]
        self.n = len(self.graded)
        self.frames = result.frames
        self.stands = (self.graded["mode"] == "stationary").any()

    def count(self, actor, frames=slice(None)):
        """Number of frames in which an actor was graded."""
        rows = self.graded[self.graded["actor_id"] == actor]
        return int(rows["frame"].isin(range(self.frames)[frames]).sum())


def street(stub):
    return GradedRun(short_run.run(STREET, lambda _: stub()))


def crossing(stub):
    scenario = Scenario.load(shipped.find("sumo-crossing"), {"duration_s": 4.8})
    return GradedRun(loop.run(scenario, lambda _: stub()))


WORLDS = {"street": street, "crossing": crossing}
RIGHT = {"hota": 1.0, "deta": 1.0, "assa": 1.0, "loca": 1.0, "mota": 1.0, "idf1": 1.0, "id_switches": 0.0,
         "missed": 0.0, "false": 0.0, "heading_abs_mean_deg": 0.0, "heading_flip_rate": 0.0,
         "missed_share": 0.0, "time_to_confirm_p90_s": 0.0, "never_confirmed": 0.0, "gospa_m": 0.0,
         "length_abs_mean_m": 0.0,
         "velocity_abs_mean_mps": 0.0, "acceleration_abs_mean_mps2": 0.0, "standing_speed_mean_mps": 0.0}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def _scans_are_simulated_once():
    with shared_scans.shared():
        yield


@pytest.fixture(scope="module", params=few(WORLDS, next(iter(WORLDS))))
def world(request):
    return WORLDS[request.param]


@pytest.fixture(scope="module")
def perfect(world):
    return world(Perfect)


def changed(run, perfect):
    """Names of the metrics that the fault has changed, without times; those of bands by the name of their metric."""
    names = [name for name in perfect.value if not name.startswith("perf.")]
    return {
        name.partition("{")[0] if name.startswith("track.") else name
        for name in names
        if not same(run.value[name], perfect.value[name])
    }


def same(a, b):
    return a == b if a is None or b is None else a == pytest.approx(b, abs=1e-6)


def of(family, *names):
    return {f"{family}.{name}" for name in names}


MOTION = of(
    "track",
    *("velocity_abs_mean_mps", "moving_velocity_abs_mean_mps", "speed_abs_mean_mps", "speed_mean_mps"),
    *("acceleration_abs_mean_mps2", "standing_speed_mean_mps"),
)
FLIPS = (
    *("heading_unflipped_mean_deg", "standing_flip_rate", "stopped_flip_rate", "parked_flip_rate"),
    "orientation_abs_mean_deg",
)
PAIRS = of("track", "position_abs_mean_m", "iou_mean", "motp")
HITS = {name for name in STANDARD if name.startswith(("track.missed", "track.false", "track.time_to", "track.never"))}
GOSPA = of("track", "gospa_m", "gospa_localisation_m2", "gospa_missed_m2", "gospa_false_m2")
LOCATED = {name for name in METRICS if name.startswith("emergence.") and "located" in name}
POSITIONS = {name for name in METRICS if name.startswith("mma.") and ("_abs_" in name or "nees" in name)}


def test_perfect(perfect):
    """Holds over hundreds of vehicle-frames, standing and moving, in both worlds."""
    assert perfect.n > 150
    right = {name: value for name, value in RIGHT.items() if perfect.stands or name != "standing_speed_mean_mps"}
    assert {name: perfect.value[f"track.{name}"] for name in right} == pytest.approx(right, abs=1e-9)
    errors = [perfect.value[f"mma.{axis}_abs_mean_m{{target=moving}}"] for axis in "xy"]
    assert errors == pytest.approx([0.0, 0.0], abs=1e-9)


def test_one_frame_late_has_the_error_of_one_frame_of_motion(world, perfect):
    """The error is the mean speed x dt; the first frame has no delay."""
    late = world(OneFrameLate)
    moving = late.graded[late.graded["mode"] != "stationary"]
    driven = np.hypot(moving["vx_world_mps"], moving["vy_world_mps"]) * DT * (moving["frame"] > 0)
    judged = late.tracks[late.tracks["judged"] & (late.tracks["true_mode"] != "stationary")]
    assert np.hypot(judged["mma_x_error_m"], judged["mma_y_error_m"]).mean() == pytest.approx(driven.mean(), rel=0.01)
    assert late.value["mma.x_abs_mean_m{target=moving}"] == pytest.approx(driven.mean(), rel=0.01)  # all drive along
    assert late.value["track.hota"] == pytest.approx(hota_if_late(late.graded), abs=0.01)
    assert late.value["track.missed"] == late.value["track.false"] == (overlap_if_late(late.graded) < 0.5).sum()
    hit_or_miss = HITS | of("track", "mota", "idf1", "fragments", "reappearance_error_m")  # a miss divides a track
    headings = of("track", "heading_abs_mean_deg", "heading_abs_p90_deg", "standing_heading_abs_mean_deg")
    headings |= of("track", *FLIPS)
    scores = PAIRS | of("track", "hota", "deta", "assa", "loca")
    assert changed(late, perfect) <= POSITIONS | MOTION | GOSPA | scores | hit_or_miss | headings | LOCATED
    squared = (late.graded[["vx_world_mps", "vy_world_mps"]] ** 2).sum(axis=1) * DT**2 * (late.graded["frame"] > 0)
    per_frame = squared.groupby(late.graded["frame"]).sum().mean()
    assert late.value["track.gospa_localisation_m2"] == pytest.approx(per_frame, rel=0.01)
    assert late.value["track.id_switches"] == 0


def overlap_if_late(graded):
    """Overlap of a box of length L with itself, shifted lengthwise by d: (L - d) / (L + d)."""
    d = np.hypot(graded["vx_world_mps"], graded["vy_world_mps"]) * DT * (graded["frame"] > 0)
    return (graded["length_m"] - d) / (graded["length_m"] + d)


def hota_if_late(graded):
    """HOTA (Luiten et al. 2021, equations (4) to (8)) of tracks that never switch vehicles.

    In c of a vehicle's n frames the overlap reaches the threshold: c true positives, n - c missed, n - c false, and the
    association of each true positive is c / (2 n - c).
    """
    scores = []
    for threshold in np.arange(0.05, 0.99, 0.05):
        hit = overlap_if_late(graded) >= threshold
        c = hit.groupby(graded["actor_id"]).sum().to_numpy()
        n = graded.groupby("actor_id").size().to_numpy()
        detection = c.sum() / (2 * n.sum() - c.sum())
        association = (c * c / (2 * n - c)).sum() / c.sum()
        scores.append(math.sqrt(detection * association))
    return np.mean(scores)


def test_swapped_ids_lower_identity_and_not_detection(world, perfect):
    """Vehicles a and b are graded in a1 and b1 frames before and a2 and b2 frames after the swap."""
    a, b = perfect.graded.groupby("actor_id").size().sort_values(kind="stable").index[-2:]
    at = 20
    swapped = world(partial(IdSwapping, pair=(a, b), at=at))
    a1, b1, a2, b2 = (swapped.count(actor, frames) for frames in (slice(at), slice(at, None)) for actor in (a, b))
    others = swapped.n - (a1 + a2 + b1 + b2)
    assert min(a1, b1, a2, b2) >= 10
    assert swapped.value["track.id_switches"] == swapped.value["track.id_switches_in_view"] == 2
    assert swapped.value["track.mota"] == pytest.approx(1 - 2 / swapped.n)
    assert swapped.value["track.idf1"] == pytest.approx((others + max(a1 + b1, a2 + b2)) / swapped.n)
    # For each of the a1 frames before the swap, a2 frames of a and b2 frames of its track do not match, and so on.
    apart = [(a1, a2 + b2), (a2, a1 + b1), (b1, b2 + a2), (b2, b1 + a1)]
    assa = (others + sum(own * own / (own + rest) for own, rest in apart)) / swapped.n
    assert swapped.value["track.assa"] == pytest.approx(assa)
    assert swapped.value["track.hota"] == pytest.approx(math.sqrt(assa))
    switches = of("track", "id_switches", "id_switches_in_view", "id_switch_rate")
    assert changed(swapped, perfect) == of("track", "hota", "assa", "idf1", "mota") | switches


@pytest.mark.parametrize("bias_deg", [5.0, 180.0])
def test_biased_yaw_changes_heading_and_corner(world, perfect, bias_deg):
    """A corner at distance r from the centre moves by 2 r sin(bias / 2); after a half turn another corner is used."""
    biased = world(partial(BiasedYaw, bias_deg=bias_deg))
    assert biased.value["track.heading_abs_mean_deg"] == pytest.approx(bias_deg)
    assert biased.value["track.heading_flip_rate"] == (bias_deg > 90)
    judged = biased.tracks[biased.tracks["judged"]]
    r = 0.5 * np.hypot(judged["length_m"], judged["width_m"])
    turned = 2 * r * math.sin(math.radians(bias_deg) / 2) if bias_deg < 90 else 0 * r
    np.testing.assert_allclose(np.hypot(judged["mma_x_error_m"], judged["mma_y_error_m"]), turned, atol=1e-6)
    assert [biased.value[f"track.{name}"] for name in ("mota", "idf1", "id_switches")] == [1, 1, 0]
    names = ("heading_abs_mean_deg", "heading_abs_p90_deg", "heading_flip_rate", "standing_heading_abs_mean_deg")
    headings = of("track", *names, *FLIPS) | MOTION | LOCATED  # of another corner if flipped
    boxes = POSITIONS | PAIRS | of("track", "hota", "deta", "assa", "loca")
    assert changed(biased, perfect) <= (headings | boxes if bias_deg < 90 else headings)
    assert changed(biased, perfect) >= of("track", "heading_abs_mean_deg", *(["hota"] if bias_deg < 90 else []))


def test_false_tracks_lower_precision_only(world, perfect):
    """A false track in each of F frames: DetA = N / (N + F), IDF1 = 2 N / (2 N + F)."""
    ghost = world(GhostMaking)
    n, false = ghost.n, ghost.frames
    assert ghost.value["track.false"] == false
    assert ghost.value["track.mota"] == pytest.approx(1 - false / n)
    assert ghost.value["track.deta"] == pytest.approx(n / (n + false))
    assert ghost.value["track.hota"] == pytest.approx(math.sqrt(n / (n + false)))
    assert ghost.value["track.idf1"] == pytest.approx(2 * n / (2 * n + false))
    assert ghost.value["track.false_on_nothing"] == false
    assert ghost.value["track.gospa_false_m2"] == pytest.approx(2.0)
    false_metrics = of("track", "false", "false_on_nothing", "false_share", "gospa_m", "gospa_false_m2")
    assert changed(ghost, perfect) == of("track", "mota", "deta", "hota", "idf1") | false_metrics


def test_forgetful_tracker_loses_hidden_vehicles(world, perfect):
    """Each uninterrupted period of c of a vehicle's n graded frames is a track: the longest counts for identity.

    The association sums up to c^2 / n. At the crossing no graded vehicle is hidden and returns: there it is perfect.
    """
    forgetful = world(Forgetful)
    periods = periods_seen(forgetful.truth)
    if world is crossing:
        assert all(len(lengths) == 1 for lengths in periods)
        assert changed(forgetful, perfect) == set()
        return
    assert forgetful.value["track.occlusion_survival"] == forgetful.value["track.hidden_2s_survival"] == 0.0
    assert forgetful.value["track.id_switches"] == sum(len(lengths) - 1 for lengths in periods) > 0
    right = sum(lengths.max() for lengths in periods)
    assert forgetful.value["track.idf1"] == pytest.approx(right / forgetful.n)
    associated = sum((lengths**2).sum() / lengths.sum() for lengths in periods)
    assert forgetful.value["track.assa"] == pytest.approx(associated / forgetful.n)
    survival = of("track", "occlusion_survival", "hidden_2s_survival")
    scores = of("track", "hota", "assa", "idf1", "mota", "id_switches", "id_switch_rate")
    assert changed(forgetful, perfect) == scores | survival


def periods_seen(truth):
    """Number of graded frames in each period with points throughout, for every vehicle that is ever graded."""
    found = []
    for _, rows in truth.sort_values("frame").groupby("actor_id"):
        seen = rows["points"] > 0
        period = (seen & ~seen.shift(fill_value=False)).cumsum()[rows["graded"]]
        found += [period.value_counts().to_numpy()] if len(period) else []
    return found
