"""Oracles: each makes the metrics of its stage ideal, does not affect earlier stages, and is named in reports."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from support import busy_street, short_run
from support.frames import Body, observe, world_frame
from support.one_bank import OneBank

from luxloop.scenarios.cli import main
from luxloop.scenarios.document.document import plain
from luxloop.scenarios.errors import DeviceError
from luxloop.scenarios.files import shipped as listing
from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.metrics.definitions import CAUSES
from luxloop.scenarios.oracle import oracle_detector, oracle_tracks
from luxloop.scenarios.oracle.oracle_tracker import OracleFactory, OracleTracker, choose
from luxloop.scenarios.oracle.oracle_tracks import OracleModelSelection, certain
from luxloop.scenarios.oracle.oracle_truth import OracleContext, Truth
from luxloop.scenarios.oracle.stage import Stage
from luxloop.scenarios.report.run_document import header
from luxloop.scenarios.run import device, loop
from luxloop.sensor_model.truth import NO_ACTOR
from luxloop.tracker import merging
from luxloop.tracker.detection.segmentation import sort_by_segment
from luxloop.tracker.records import METHODS, MODELS, NOT_USED, Linkage, Segments, Status
from luxloop.tracker.tracker import Tracker, TrackerConfig
from luxloop.tracker.tracking.filters import FilterConfig, motion
from luxloop.tracker.tracking.hypotheses import Hypotheses, Predictions
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.track_table import empty

SEGMENTATION = tuple(f"segmentation.{rate}_rate" for rate in ("over", "under", "missed"))


def values(metrics, *names):
    return [metrics[name].value for name in names]


def of(stage):
    """Metrics of the busy street with one oracle."""
    return busy_street.blamed().by_truth[stage]


def shipped():
    return busy_street.blamed().shipped.metrics


@cache
def truly_fitted():
    """The busy street with the fit oracle, including tables, which blame does not keep."""
    return short_run.run(busy_street.TEXT, OracleFactory([Stage.FIT]))


@cache
def without_feedback(stages):
    """Metrics of the busy street without any effect of tracks on detection."""
    text = busy_street.TEXT + '[tracker.deskew]\nmotion = "ego"\n'
    with patch.object(merging, "MEMBER_FRACTION_MIN", 2.0):  # more points than any segment has in a box
        return short_run.run(text, OracleFactory(list(stages))).metrics


def test_an_oracle_tracker_without_oracles_equals_the_shipped_tracker():
    """Bit for bit."""
    assert short_run.run(busy_street.TEXT, OracleFactory([])).trace_hash == busy_street.blamed().shipped.trace_hash


def test_true_segmentation_has_no_splits_merges_or_misses():
    assert values(of(Stage.SEGMENTATION), *SEGMENTATION) == [0.0, 0.0, 0.0]
    assert shipped()["segmentation.under_rate"].value > 0.02


def test_true_outliers_are_exactly_the_noise():
    graded = [
        (metric.value, shipped()[name].value)
        for cause in CAUSES.values()
        for name in (f"outliers.precision{{cause={cause}}}", f"outliers.recall{{cause={cause}}}")
        if (metric := of(Stage.OUTLIERS)[name]).value is not None
    ]
    assert len(graded) >= 6
    assert {ideal for ideal, _ in graded} == {1.0}
    assert sum(real for _, real in graded) < len(graded) - 0.2


def test_a_true_fit_has_the_true_heading_and_the_true_corners():
    run = truly_fitted()
    assert run.metrics["fit.heading_abs_mean_deg"].value == pytest.approx(0.0, abs=1e-6)
    assert run.metrics["fit.regret_deg"].value == pytest.approx(0.0, abs=1e-6)
    assert run.metrics["fit.heading_abs_mean_deg{method=tlinkage}"].value > 0.1  # the other methods are still graded
    best = run.tables["fits"].query("best")
    corners = best[best["view"] == "l_shape"]
    assert len(corners) > 40
    assert corners["position_error_m"].max() < 1e-6  # in full view; a half occluded vehicle is truncated
    assert shipped()["fit.heading_abs_mean_deg"].value > 0.1


def test_a_true_fit_is_at_the_time_of_the_scan():
    """The speed of this car is not known yet: its points are not deskewed, with errors of up to 1.6 m."""
    fast = short_run.TEXT.replace("speed_mps = 5", "speed_mps = 40").replace("x_m = 9\ny_m = 3", "x_m = 0\ny_m = -4")
    first = short_run.run(fast, OracleFactory([Stage.FIT]), duration_s=0.08).tables["fits"].query("best")
    car = first[first["actor_id"] == 1]
    assert len(car) == 1
    assert car["position_error_m"].max() < 1e-6


def test_a_true_fit_of_a_rear_is_not_a_whole_vehicle():
    best = truly_fitted().tables["fits"].query("best")
    rear = best[best["view"] == "rear"]
    assert len(rear) > 10
    # Its heading is modulo a quarter turn: a rear is as wide as the car and has nearly no depth.
    extents = np.sort(rear[["length_m", "width_m"]], axis=1)
    np.testing.assert_allclose(extents[:, 1], rear["true_width_m"], atol=1e-6)
    assert extents[:, 0].max() < 1.5


def test_a_track_of_true_fits_has_the_true_ends():
    """The tracker adds 0.27 m to every whole length, for the rounded corners that real fits lack."""
    run = truly_fitted()
    fits = run.tables["fits"].query("best and view == 'l_shape'")
    extents = np.sort(fits[["length_m", "width_m"]], axis=1)
    whole = fits[np.abs(extents[:, 1] - fits["true_length_m"]) < 1e-6]
    tracks = run.tables["tracks"].query("judged").merge(whole[["frame", "actor_id", "true_length_m"]])
    assert len(tracks) > 40
    assert (tracks["length_m"] - tracks["true_length_m"]).abs().max() < 0.1


def test_a_track_with_a_true_size_is_exact():
    run = short_run.run(busy_street.APART, OracleFactory([Stage.SIZE]))
    errors = values(run.metrics, "track.length_abs_mean_m", "track.width_abs_mean_m")
    assert errors == pytest.approx([0.0, 0.0], abs=1e-6)
    assert run.metrics["track.length_abs_mean_m"].n > 40


def test_true_association_has_no_id_switches():
    text = busy_street.TEXT + "[tracker.association]\ngate_chi2 = 0.02\n"  # nearly no box is inside such a gate
    lost, kept = short_run.run(text).metrics, short_run.run(text, OracleFactory([Stage.ASSOCIATION]))
    assert lost["track.id_switches"].value + lost["track.missed"].value > 0.6 * lost["track.missed"].n
    assert values(kept.metrics, "track.id_switches") == [0.0]
    ill = kept.tables["tracks"].query("status == 'confirmed' and not iou >= 0.5")
    assert (ill["length_m"] > 2 * 4.4).all()  # two parked cars in one segment, which no association can separate
    assert kept.metrics["track.missed"].value <= shipped()["track.missed"].value
    assert of(Stage.ASSOCIATION)["track.id_switches"].value == 0.0


@pytest.mark.slow
def test_a_truck_seen_in_two_pieces_is_one_track():
    """Side and rear, with a blind gap between them, have two tracks at first, which are merged."""
    scenario = Scenario.load(listing.find("truck-shadow"), {"duration_s": 2.4})
    as_is, true = (loop.run(scenario, OracleFactory(stages)).metrics for stages in ([], [Stage.ASSOCIATION]))
    assert true["track.missed"].value <= as_is["track.missed"].value
    assert true["track.false"].value <= as_is["track.false"].value
    assert true["track.id_switches"].value == 0.0


def test_the_true_model_is_always_the_true_mode():
    assert values(of(Stage.MODEL), "mma.mode_accuracy", "mma.switch_latency_frames") == [1.0, 0.0]
    assert shipped()["mma.mode_accuracy"].value < 0.95


def test_true_confirmation_confirms_vehicles_in_their_first_frame_and_nothing_else():
    cyclist = (
        '[[traffic.actor]]\nkind = "bicycle"\nx_m = 6\ny_m = 6\nmotion = [{ kind = "straight", speed_mps = 7 }]\n\n'
    )
    text = busy_street.APART.replace("[[traffic.obstacle]]", f"{cyclist}[[traffic.obstacle]]")
    as_is, true = (short_run.run(text, OracleFactory(stages)) for stages in ([], [Stage.CONFIRMATION]))
    names = ("track.time_to_confirm_p90_s", "track.never_confirmed", "track.false_on_nothing")
    assert values(true.metrics, *names) == [0.0, 0.0, 0.0]
    assert as_is.metrics["track.time_to_confirm_s"].value > 0.1
    status = true.tables["tracks"].groupby("status", observed=True).size()
    assert status["tentative"] > 10  # of the cyclist
    assert values(true.metrics, *SEGMENTATION) == values(as_is.metrics, *SEGMENTATION)


@pytest.mark.slow
def test_true_confirmation_coasts_as_the_tracker_does():
    """A hidden vehicle's track keeps its id."""
    scenario = Scenario.load(listing.find("truck-shadow"), {"duration_s": 6.0})
    true = loop.run(scenario, OracleFactory([Stage.CONFIRMATION]))
    assert (true.tables["tracks"]["status"] == "coasting").any()


@pytest.mark.parametrize(
    ("stage", "others"),
    [
        pytest.param(Stage.OUTLIERS, SEGMENTATION, marks=pytest.mark.slow),
        (Stage.FIT, (*SEGMENTATION, "outliers.recall{cause=mirror}", "outliers.precision{cause=layer_overlap}")),
        (Stage.ASSOCIATION, (*SEGMENTATION, "fit.heading_abs_mean_deg")),
        pytest.param(Stage.MODEL, SEGMENTATION, marks=pytest.mark.slow),
    ],
)
def test_an_oracle_does_not_affect_earlier_stages(stage, others):
    """Tracks, which it does affect, are used neither to deskew points nor to join the segments of long vehicles."""
    ideal, real = (without_feedback(stages) for stages in ((stage,), ()))
    for name in others:
        assert (ideal[name].value, ideal[name].n) == (real[name].value, real[name].n), name
        assert real[name].n > 0


def test_oracles_combine():
    """Except that of confirmation: a vehicle that has just come into sight has a guess for a box."""
    run = short_run.run(busy_street.TEXT, OracleFactory([stage for stage in Stage if stage != Stage.CONFIRMATION]))
    assert values(run.metrics, *SEGMENTATION) == [0.0, 0.0, 0.0]
    assert values(run.metrics, "outliers.recall{cause=mirror}", "mma.mode_accuracy") == [1.0, 1.0]
    assert run.metrics["fit.heading_abs_mean_deg"].value == pytest.approx(0.0, abs=1e-6)
    assert values(run.metrics, "track.id_switches", "track.false") == [0.0, 0.0]
    alone = [metrics["track.idf1"].value for _, metrics in oracles()]
    assert run.metrics["track.idf1"].value > sorted(alone)[-2]  # one of them alone may start a track earlier


def test_with_all_oracles_every_vehicle_has_one_track_from_its_first_frame():
    run = short_run.run(busy_street.TEXT, OracleFactory(tuple(Stage)))
    assert values(run.metrics, *SEGMENTATION, "track.id_switches", "track.time_to_confirm_s") == [0.0] * 5
    followed = run.tables["truth"].query("graded").groupby("actor_id")["track_id"].nunique()
    assert followed.tolist() == [1] * len(followed)


def oracles():
    return busy_street.blamed().by_truth.items()


def test_oracles_are_named_in_report_folder_and_json(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path())
    command = ["run", "short.toml", "--no-recording", "--oracle", "association", "--oracle", "fit"]
    assert main(command) == 0
    assert "device oracle: fit, association" in capfd.readouterr().out
    folder = Path("runs/short-seed4-oracle-association-fit")
    assert json.loads((folder / "result.json").read_text())["config"]["device"] == "oracle: fit, association"
    assert main([*command, "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["config"]["device"] == "oracle: fit, association"
    assert [path.name for path in Path("runs").iterdir()] == [folder.name]


def test_the_shipped_tracker_is_not_mentioned_in_the_report():
    run = short_run.result()
    assert run.config["device"] == device.SHIPPED
    assert not any("device" in plain(block.words) for block in header(run))
    other = replace(run, config={**run.config, "device": "mine:Tracker"})
    assert any(plain(block.words).endswith("\ndevice mine:Tracker") for block in header(other))


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["--oracle", "fitt"], "Invalid value for '--oracle'"),
        (["--oracle", "fit", "--tracker", "mine:Tracker"], "--oracle fit: oracles replace stages of the shipped track"),
    ],
)
def test_an_invalid_oracle_gives_one_error_line(arguments, error, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    short_run.write(Path())
    assert main(["run", "short.toml", *arguments]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert error in err
    assert [path.name for path in Path().iterdir()] == ["short.toml"]


def test_the_shipped_tracker_can_be_combined_with_an_oracle():
    assert choose(device.SHIPPED, [Stage.FIT]) == OracleFactory([Stage.FIT])
    assert choose(None, []) is device.load(device.SHIPPED)


def test_a_bank_that_selects_no_model_has_no_oracle():
    with pytest.raises(DeviceError, match='method = "imm" selects no model'):
        OracleTracker(Tracker(TrackerConfig(mma=MmaConfig(method="imm"))), [Stage.MODEL])
    OracleTracker(Tracker(TrackerConfig(mma=MmaConfig(method="imm"))), [Stage.FIT])


def test_actors_are_segments_and_other_points_keep_theirs():
    row = np.array([0, 0, 0, 1, 2, 2, 2, -1, -1])
    keep = np.array([1, 1, 1, 1, 1, 0, 1, 1, 1], dtype=bool)
    rest = Segments(np.array([-1] * 7 + [0, -1]), 1)
    found = oracle_detector.actors_first(row, keep, rest, points_min=2)
    assert found.label.tolist() == [0, 0, 0, -1, 1, -1, 1, 2, -1]  # one point of actor 1 is too few
    assert found.count == 3


def test_a_segment_of_noise_is_removed():
    """A cloud of spray gets no line, rectangle or box; as a part of a segment only its points are removed."""
    segments = Segments(np.array([0, 0, 0, 1, 1, NOT_USED]), 2)
    noise = np.array([0, 0, 1, 1, 1, 0], dtype=bool)
    on_owner = np.array([1, 1, 1, 0, 0, 0], dtype=bool)

    def real(points):
        clean = points.segments
        assert clean.count == 1
        assert clean.label.tolist() == [0, 0, -1, -1, -1, -1]
        return Linkage(np.array([0, -1, -1, -1, -1, -1]), np.array([0.3]))  # it would remove a clean point

    linkage = oracle_detector.link(real, sort_by_segment(np.zeros((6, 2)), segments), noise, on_owner)
    assert linkage.line.tolist() == [0, 1, -1, -1, -1, -1]
    assert linkage.heading.tolist() == [0.3, 0.0]
    gone = ~oracle_detector.has_points((linkage.line >= 0) & (segments.label >= 0), segments)
    assert gone.tolist() == [False, True]
    assert oracle_detector.with_placeholder_lines(linkage, segments, gone).line.tolist() == [0, 1, -1, 0, 0, -1]


WET = """\
description = "A car drives beside the ego through heavy rain, and both throw it up."
duration_s = 0.8
[traffic]
kind = "scripted"
[traffic.ego]
motion = [{ kind = "straight", speed_mps = 20 }]
[[traffic.actor]]
x_m = 2
y_m = 3
motion = [{ kind = "straight", speed_mps = 20 }]
[noise.rain]
enabled = true
rate_mm_per_h = 80.0
[noise.spray]
enabled = true
water_film_mm = 3.0
echo_share = 0.8
"""
PAPER = "".join(f'[tracker.{stage}]\n{key} = "paper"\n' for stage, key in
                (("linkage", "variant"), ("selection", "variant"), ("mma", "method")))  # fmt: skip


@pytest.mark.parametrize("variant", ["", PAPER], ids=["shipped", "paper"])
def test_clouds_of_spray_are_removed_in_every_variant_and_in_recordings(variant, tmp_path):
    """Segments without a rectangle must not cause errors in later stages."""
    factory = OracleFactory([Stage.OUTLIERS])
    run = short_run.run(WET + variant, factory, record_to=tmp_path / "recording.rrd", duration_s=0.4)
    assert run.metrics["outliers.recall{cause=spray}"].value == 1.0
    assert run.metrics["outliers.recall{cause=spray}"].n > 20


def test_ends_with_points_are_true_and_others_are_truncated():
    points = np.array([[-2.0, -0.9], [0.4, -0.85], [1.2, 3.0]])
    low, high = oracle_detector.visible(points[:2], np.zeros(2, dtype=int), np.array([[4.6, 1.8]]))
    np.testing.assert_allclose([low, high], [[[-2.3, -0.9]], [[0.4, -0.85]]])
    low, high = oracle_detector.visible(points[2:], np.zeros(1, dtype=int), np.array([[4.6, 1.8]]))
    np.testing.assert_allclose([low, high], [[[1.2, 0.9]], [[1.2, 0.9]]])  # never outside of the vehicle


def test_a_box_updates_its_actor_and_the_gate_chooses_among_its_tracks():
    track_actor, box_actor = np.array([7, 7, 8, NO_ACTOR]), np.array([7, 7, 9, NO_ACTOR, 8])
    in_gate = np.zeros((4, 5), dtype=bool)
    in_gate[[1, 2, 3], 0] = in_gate[0, 3] = True
    misread = np.zeros((4, 5), dtype=bool)
    misread[[0, 1], [1, 0]] = True  # has no effect inside the gate
    may = oracle_tracks.admissible(track_actor, box_actor, in_gate, misread)
    assert np.argwhere(may).tolist() == [[1, 0], [1, 1], [2, 4]]


def test_true_centres_in_the_odometry_frame():
    """The ego stands at (10, 0) in the world and has driven 5 m to the left since the first scan."""
    bodies = [Body(3, 12.0, 0.0), Body(5, 10.0, 4.0)]
    frame = world_frame(0, bodies, ego=(10.0, 0.0, 0.0))
    truth = Truth.of(frame, observe(frame, bodies)[1])
    center = truth.center_odom(np.array([5, NO_ACTOR, 4, 3]), np.array([0.0, 5.0, np.pi / 2]))
    np.testing.assert_allclose(center, [[-4.0, 5.0], [np.nan] * 2, [np.nan] * 2, [0.0, 7.0]], atol=1e-12)


def test_a_box_that_is_a_cars_length_off_is_misread():
    """The track is 0.3 m from its vehicle; one box corrects it, the other moves it to the wrong end."""
    one = np.ones((1, 1))
    predictions = Predictions(
        position=np.array([[[10.0, 0.9]]]), velocity=np.zeros((1, 1, 2)), covariance=np.eye(2)[None, None],
        probability=one, heading=np.zeros(1), heading_variance=np.zeros(1), size=np.array([[4.6, 1.8]]),
        known_size=np.array([[4.6, 1.8]]), whole=np.ones((1, 2), dtype=bool), corner_sign=np.array([[-1, 1]]),
    )  # fmt: skip
    assert (predictions.selected - predictions.to_corner).tolist() == [[12.3, 0.0]]
    flags = np.zeros((1, 2, 2), dtype=bool)
    hypotheses = Hypotheses(
        heading=np.zeros((1, 2)), size=np.ones((1, 2, 2)), untruncated=flags,
        innovation=np.array([[[[0.3, 0.0]], [[4.6, 0.0]]]]),
        covariance=np.zeros((1, 2, 2, 2)), ambiguity=np.zeros((1, 2, 2, 2)), corner_sign=np.ones((1, 2, 2)),
        end_visible=flags,
    )  # fmt: skip
    assert oracle_tracks.leads_away(predictions, hypotheses, np.array([[12.6, 0.0]])).tolist() == [[False, True]]
    assert oracle_tracks.leads_away(predictions, hypotheses, np.full((1, 2), np.nan)).tolist() == [[False, False]]


def test_the_largest_box_of_a_new_actor_starts_a_track():
    box_actor, support = np.array([7, 7, 8, 9, NO_ACTOR, NO_ACTOR]), np.array([5, 9, 9, 9, 9, 9])
    free = np.array([0, 0, 0, 1, 1, 0], dtype=bool)
    assert oracle_tracks.newcomers(box_actor, support, np.array([8, 9]), free).tolist() == [0, 1, 0, 1, 1, 0]


def test_the_first_id_of_an_actor_is_kept():
    tracks = empty(MODELS, rows=3)
    tracks.id[:], tracks.hits[:] = [3, 5, 6], [9, 4, 7]
    tracks.status[:] = [Status.DEAD, Status.CONFIRMED, Status.CONFIRMED]
    oracle_tracks.hand_over_id(tracks, np.arange(3))
    assert tracks.id.tolist() == [6, 5, 3]
    oracle_tracks.hand_over_id(tracks, np.arange(3))
    assert tracks.id.tolist() == [6, 5, 3]


def test_an_oracle_selects_the_true_mode_regardless_of_innovations():
    """Mixing starts the other filters from the selected one, and minutes of standing keep all logarithms finite."""
    frame = world_frame(0, [Body(3, 12.0, 0.0)])
    context = OracleContext()
    context.truth = replace(Truth.of(frame, observe(frame, [Body(3, 12.0, 0.0)])[1]), mode={3: 0})
    context.box_actor = np.array([3])
    context.add_tracks(np.array([0]))
    bank = OneBank(0.01 * np.eye(2), selection=OracleModelSelection(MmaConfig(), context))
    bank.selection.select(bank.table)
    for _ in range(5000):
        bank.predict(motion(0.08, FilterConfig()))
        bank.observe(np.full((len(MODELS), 2), 0.3), 0.01 * np.eye(2))
        assert bank.probability.argmax() == 0
    np.testing.assert_array_equal(bank.probability, certain(0))
    bank.table.id[0] = 7  # a track without an actor
    bank.predict(motion(0.08, FilterConfig()))
    assert bank.probability[0] < certain(0)[0]


def test_a_true_fit_replaces_the_refined_column():
    assert METHODS[oracle_detector.BEST] == "refined"
