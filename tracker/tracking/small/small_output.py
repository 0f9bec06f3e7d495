"""Rows of small road users in the `Tracks` record."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from luxloop.tracker.arrays import Bools, Floats, Ints
from luxloop.tracker.geometry import rotate
from luxloop.tracker.records import PREDICTION_S, Tracks
from luxloop.tracker.tracking.small.small_config import SmallConfig
from luxloop.tracker.tracking.small.small_tracks import SmallTracks

ABEAM_M = 1.0
"""Distance along an axis over which the near end changes [m]: from abeam, both ends of a bicycle are visible."""
_COLUMNS = tuple(field.name for field in fields(Tracks))


def appended(
    tracks: Tracks,
    kept: Bools,
    own_id: Ints,
    small: Bools,
    added: SmallTracks,
    added_id: Ints,
    ego_odom: Floats,
    config: SmallConfig,
) -> Tracks:
    """Return the rows `kept` (T,) of a record, renamed to `own_id` (T,), then a row for each small road user.

    Parameters
    ----------
    small
        (T,) class of the rows of the record.
    added_id
        (K,) reported ids.
    ego_odom
        (2,) position of the ego [m].
    """
    if kept.all() and not len(added):
        return replace(tracks, id=own_id, small=small)
    own: dict[str, Any] = {name: values for name in _COLUMNS if isinstance(values := getattr(tracks, name), np.ndarray)}
    own |= {"id": own_id, "small": small}
    if not kept.all():
        own = {name: values[kept] for name, values in own.items()}
    if len(added):
        rows = record(added, added_id, ego_odom, config, tracks.models)
        own = {name: np.concatenate([values, getattr(rows, name)]) for name, values in own.items()}
    return replace(tracks, **own)


def record(tracks: SmallTracks, ids: Ints, ego_odom: Floats, config: SmallConfig, models: tuple[str, ...]) -> Tracks:
    """Return the record of small road users: the constant velocity model is the selected one, at the box centre."""
    count, m = len(tracks), len(models)
    center = centers(tracks, ego_odom)
    mean, covariance = np.zeros((count, 8)), np.zeros((count, 8, 8))
    mean[:, :2], mean[:, 2:4], mean[:, 6] = center, tracks.mean[:, 2:], tracks.heading
    covariance[:, :4, :4] = tracks.covariance
    covariance[:, [4, 5], [4, 5]] = config.acceleration_std_mps2**2
    across = config.acceleration_std_mps2 / np.maximum(tracks.speed, config.speed_min_mps)
    variance = np.trace(tracks.covariance[:, 2:, 2:], axis1=1, axis2=2) / np.maximum(tracks.speed, 0.1) ** 2
    covariance[:, 6, 6], covariance[:, 7, 7] = variance, across**2
    model = models.index("cv") if "cv" in models else 0
    probability = np.zeros((count, m))
    probability[:, model] = 1.0
    ahead = center[:, None] + np.array(PREDICTION_S)[None, :, None] * tracks.mean[:, None, 2:]
    return Tracks(
        id=ids,
        status=tracks.status.astype(np.uint8),
        mean=mean,
        covariance=covariance,
        model_probability=probability,
        model=np.full(count, model),
        model_position_odom=np.repeat(center[:, None], m, axis=1),
        corner_sign=np.zeros((count, 2), dtype=np.int64),
        size=tracks.size,
        model_covariance_odom=np.repeat(tracks.covariance[:, None, :2, :2], m, axis=1),
        model_nis=np.full((count, m), np.nan),
        prediction_odom=np.repeat(ahead[:, None], m + 1, axis=1),
        small=np.ones(count, dtype=np.bool_),
        models=models,
    )


def centers(tracks: SmallTracks, ego_odom: Floats) -> Floats:
    """(K, 2) centres [m]: the hidden part of a box lies behind its visible points, seen from the ego."""
    from_ego = rotate(tracks.mean[:, :2] - ego_odom, -tracks.heading)
    hidden = np.maximum(tracks.size - tracks.extent, 0.0)
    return tracks.mean[:, :2] + rotate(0.5 * hidden * np.clip(from_ego / ABEAM_M, -1.0, 1.0), tracks.heading)
