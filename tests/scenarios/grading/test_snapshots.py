"""Snapshots: the worst frames of each kind, limited in number, with all their points."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from support import short_run

from luxloop.scenarios.grading.snapshots import APART_S, CONFIRMATION_S, PER_KIND, SNAPSHOT_KINDS
from luxloop.scenarios.grading.worst_frames import worst_frames
from luxloop.tracker.tracker import Tracker


class Forgetful(Tracker):
    """Blind in the first two seconds and from four to five seconds; afterwards all tracks have new ids."""

    def step(self, scan):
        blind = scan.time < 2.0 or 4.0 <= scan.time < 5.0
        tracks, trace = super().step(replace(scan, points_ego=scan.points_ego + np.float32(np.nan)) if blind else scan)
        return replace(tracks, id=tracks.id + 1000 * (scan.time >= 5.0)), trace


@pytest.fixture(scope="module")
def result():
    """Six seconds; the moving car is slow, so both cars stay in range."""
    return short_run.run(short_run.TEXT.replace("speed_mps = 5", "speed_mps = 2"), Forgetful, duration_s=6.0)


def test_frames_of_a_kind_are_limited_in_number_and_apart_in_time(result):
    kept = result.tables["snapshots"]
    assert set(kept["kind"]) >= {"detection", "fit_heading"}
    for _, of_kind in kept.groupby("kind", observed=True):
        assert len(of_kind) <= PER_KIND
        assert of_kind["time_s"].sort_values().diff().dropna().ge(APART_S).all()
        assert of_kind["badness"].is_monotonic_decreasing
    assert kept["kind"].cat.categories.tolist() == list(SNAPSHOT_KINDS)


def test_kept_frame_is_the_worst_one(result):
    truth, fits = result.tables["truth"], result.tables["fits"]
    lost = (
        truth[truth["graded"] & (truth["track_id"] < 0) & (truth["time_s"] >= CONFIRMATION_S)].groupby("frame").size()
    )
    false = result.tables["tracks"].query("verdict == 'false'").groupby("frame").size()
    wrong = lost.add(false, fill_value=0)
    kept = result.tables["snapshots"].set_index("kind")
    detection = kept.loc[["detection"]].iloc[0]
    assert detection["badness"] == wrong.max() == wrong[detection["frame"]]
    missed = truth[truth["graded"] & (truth["track_id"] < 0) & (truth["frame"] == detection["frame"])]
    assert len(missed) == 2
    named = "; ".join(f"no track on vehicle {name}" for name in missed["name"])
    assert detection["what"].startswith(named)  # false tracks follow
    fit = kept.loc[["fit_heading"]].iloc[0]
    assert fit["badness"] >= fits.loc[fits["best"], "heading_error_deg"].abs().max() - 1e-9
    assert f"{fit['badness']:.1f}" in fit["what"]


def test_new_vehicle_does_not_count_as_missed(result):
    """Fails when the first frames, before any track confirmation, are kept."""
    kept = result.tables["snapshots"]
    assert (kept.loc[kept["kind"] == "detection", "time_s"] >= CONFIRMATION_S).all()


def test_id_switch_is_kept(result):
    kept = result.tables["snapshots"].query("kind == 'identity'")
    assert len(kept) == 1
    assert (kept["badness"].item(), round(kept["time_s"].item(), 2)) == (2.0, 5.04)
    assert kept["what"].item().count(" goes from track ") == 2


def test_position_is_that_of_the_named_vehicle(result):
    """Fails when the position or the ego's pose belongs to another frame or vehicle."""
    truth = result.tables["truth"].set_index(["frame", "name"])
    named = result.tables["snapshots"].query("kind != 'detection'")
    assert len(named) >= 3
    for row in named.to_dict("records"):
        actor = truth.loc[(row["frame"], re.search(r"vehicle (\S+)", row["what"])[1])]
        turn, x, y = row["ego_yaw_world_rad"], row["x_ego_m"], row["y_ego_m"]
        assert row["ego_x_world_m"] + np.cos(turn) * x - np.sin(turn) * y == pytest.approx(actor["x_world_m"])
        assert row["ego_y_world_m"] + np.sin(turn) * x + np.cos(turn) * y == pytest.approx(actor["y_world_m"])


def test_all_points_of_kept_frames_are_kept(result):
    points, truth = result.tables["snapshot_points"], result.tables["truth"]
    assert set(points["frame"]) == set(result.tables["snapshots"]["frame"])
    own = points[points["actor_id"] >= 0].groupby(["frame", "actor_id"]).size()
    counted = truth[truth["frame"].isin(points["frame"]) & (truth["points"] > 0)].set_index(["frame", "actor_id"])
    pd.testing.assert_series_equal(own, counted["points"].sort_index(), check_names=False)


def test_new_vehicles_without_a_track_are_not_the_worst_frames_of_missed(result):
    worst = worst_frames(result, "track.missed", count=1)[0]
    assert worst.time_s >= CONFIRMATION_S
    assert worst.what == "no track overlaps vehicle car.1; no track overlaps vehicle car.2"
