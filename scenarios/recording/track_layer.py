"""Tracks of a recording: rectangles, names, velocities and trails.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.scenarios.recording import blueprint
from luxloop.scenarios.recording.archetypes import boxes, flat, texts
from luxloop.tracker.records import Status, Tracks

if TYPE_CHECKING:
    import rerun as rr


class TrackLayer:
    """Draws the tracks of each frame, and remembers their last positions for the trails."""

    def __init__(self) -> None:
        self._last_center_odom: dict[int, Floats] = {}

    def archetypes(self, tracks: Tracks) -> "dict[str, rr.AsComponents]":
        """Return what to log of one frame, by path below `world/odom`."""
        import rerun as rr

        confirmed, coasting = tracks.status == Status.CONFIRMED, tracks.status == Status.COASTING
        hues = np.array(blueprint.CYCLE)[tracks.id % len(blueprint.CYCLE)]
        colors = hues * np.where(confirmed, 1.0, blueprint.DIM)[:, None]
        short_names = np.array([*(blueprint.SHORT_NAMES[model] for model in tracks.models), ""])  # the last: `NO_MODEL`
        suffix = np.where(confirmed, short_names[tracks.model], np.where(coasting, "coasting", ""))
        named = confirmed | coasting
        rows = zip(tracks.id, suffix, named, strict=True)
        labels = [f"{track} {text}".rstrip() if shown else "" for track, text, shown in rows]
        center, yaw = tracks.center_odom, tracks.mean[:, 6]
        line_ui = np.where(confirmed, 2.5, 1.0)
        ahead = (0.5 * tracks.size[:, :1] + blueprint.NAME_GAP_M) * np.column_stack([np.cos(yaw), np.sin(yaw)])
        velocities = rr.Arrows3D(
            origins=flat(center),
            vectors=flat(np.nan_to_num(tracks.mean[:, 2:4])),
            colors=colors.astype(np.uint8),
            radii=rr.Radius.ui_points(1.0),
        )
        return {
            "tracks": boxes(np.column_stack([center, yaw]), flat(tracks.size), colors, line_ui=line_ui),
            "tracks/names": texts(center + ahead, labels, colors),
            "velocities": velocities,
            "trails": self._trails(tracks.id, center, (blueprint.DIM * hues).astype(np.uint8)),
        }

    def _trails(self, track_id: Ints, center_odom: Floats, colors: npt.NDArray[np.uint8]) -> "rr.LineStrips3D":
        """Return the last step of each trail; the view shows the steps of the last seconds together."""
        import rerun as rr

        current = dict(zip(track_id.tolist(), flat(center_odom), strict=True))
        steps = [[self._last_center_odom.get(track, position), position] for track, position in current.items()]
        self._last_center_odom = current
        return rr.LineStrips3D(steps, colors=colors, radii=rr.Radius.ui_points(1.0))
