"""Tracks that count for people and riders, and the actor that each of them is on."""

from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy

from luxloop.scenarios.arrays import Ints
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.scenarios.grading.matching import CONTINUITY
from luxloop.scenarios.metrics.definitions import GROUPS
from luxloop.sensor_model.truth import NO_ACTOR

SMALL, VEHICLE = "small", "vehicle"
"""Names of the classes that a tracker gives to its tracks, in the column `label` of the table `tracks`."""


class SmallTracks(NamedTuple):
    """Tracks that may be on people or riders, and their distances."""

    tracks: pd.DataFrame
    """Rows of the table `tracks`, with `on`, the actor that the track is on, or `NO_ACTOR`, and `near`, the nearest
    person or rider within `match_distance_m`, or `NO_ACTOR`."""
    pairs: pd.DataFrame
    """A row per frame, actor and track within `match_distance_m`: `actor_id`, `track_id`, `distance_m`, and `iou`, the
    similarity 1 - distance / match_distance_m."""


def small_tracks(
    truth: pd.DataFrame, tracks: pd.DataFrame, overlaps: pd.DataFrame, config: GradingConfig
) -> SmallTracks:
    """Return the confirmed tracks that may be on people or riders.

    A track that the tracker calls a vehicle, or that follows an actor of another class, is none. A tracker that does
    not tell small road users from vehicles can only be right: its tracks count where they are near a person or rider.

    Parameters
    ----------
    truth, tracks, overlaps
        Tables of a run.
    """
    users = truth[truth["kind"].isin(list(GROUPS.values()))]
    others = truth.loc[~truth["kind"].isin(list(GROUPS.values())), "actor_id"].unique()
    label = tracks["label"].astype(object)
    candidates = tracks[(tracks["status"] == "confirmed") & (label != VEHICLE) & ~tracks["actor_id"].isin(others)]
    pairs = _pairs(users, candidates, config.match_distance_m)
    candidates = candidates.assign(on=_assigned(candidates, pairs), near=_nearest(candidates, pairs))
    elsewhere = candidates["near"] == NO_ACTOR
    on_other = _rows_in(candidates, overlaps[overlaps["actor_id"].isin(others)])
    unknown = candidates["label"].isna()
    outside = candidates["range_m"] > config.vulnerable_range_max_m
    return SmallTracks(candidates[~(elsewhere & (on_other | unknown | outside))], pairs)


def _pairs(users: pd.DataFrame, candidates: pd.DataFrame, reach_m: float) -> pd.DataFrame:
    """Return the pairs within `reach_m` [m], with their distances and similarities."""
    place = ["x_world_m", "y_world_m"]
    pairs = users[["frame", "actor_id", *place]].merge(
        candidates[["frame", "track_id", *place]], on="frame", suffixes=("", "_track")
    )
    offset = pairs[place].to_numpy(np.float64) - pairs[[f"{name}_track" for name in place]].to_numpy(np.float64)
    distance = np.hypot(offset[:, 0], offset[:, 1])
    pairs = pairs[["frame", "actor_id", "track_id"]].assign(distance_m=distance, iou=1.0 - distance / reach_m)
    return pairs[pairs["iou"] > 0.0]


def _assigned(candidates: pd.DataFrame, pairs: pd.DataFrame) -> Ints:
    """(n,) actor that each track is on: one to one, pairs of the last frame first, then the nearest ones."""
    before: dict[int, int] = {}
    found: dict[tuple[int, int], int] = {}
    for frame, rows in pairs.groupby("frame", sort=True):
        actors, actor = np.unique(rows["actor_id"], return_inverse=True)
        tracks, track = np.unique(rows["track_id"], return_inverse=True)
        score = np.zeros((len(actors), len(tracks)))
        score[actor, track] = rows["iou"]
        kept = np.array([before.get(one, NO_ACTOR) for one in tracks.tolist()])
        score += CONTINUITY * ((actors[:, None] == kept) & (score > 0.0))
        row, column = scipy.optimize.linear_sum_assignment(score, maximize=True)
        paired = score[row, column] > 0.0
        before = dict(zip(tracks[column[paired]].tolist(), actors[row[paired]].tolist(), strict=True))
        found |= {(int(frame), one): on for one, on in before.items()}
    keys = zip(candidates["frame"].tolist(), candidates["track_id"].tolist(), strict=True)
    return np.array([found.get(key, NO_ACTOR) for key in keys], dtype=np.int64)


def _nearest(candidates: pd.DataFrame, pairs: pd.DataFrame) -> Ints:
    """(n,) nearest person or rider within reach of each track."""
    nearest = pairs.sort_values("distance_m", kind="stable").drop_duplicates(["frame", "track_id"])
    actor = nearest.set_index(["frame", "track_id"])["actor_id"]
    keys = pd.MultiIndex.from_frame(candidates[["frame", "track_id"]])
    return np.asarray(actor.reindex(keys).fillna(NO_ACTOR), dtype=np.int64)


def _rows_in(candidates: pd.DataFrame, rows: pd.DataFrame) -> pd.Series:
    """(n,) mask of the tracks that have a row in their frame."""
    keys = pd.MultiIndex.from_frame(candidates[["frame", "track_id"]])
    return pd.Series(keys.isin(pd.MultiIndex.from_frame(rows[["frame", "track_id"]])), index=candidates.index)
