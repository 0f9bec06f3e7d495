"""Recording of several trackers on the same drive: the scans and truth of a run, and the tracks of all of them.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from luxloop.arrays import Floats
from luxloop.scenarios.errors import InputError, OutputError
from luxloop.scenarios.files import atomic_file
from luxloop.scenarios.rerun_log import blueprint
from luxloop.scenarios.rerun_log.archetypes import Color, boxes, flat, texts
from luxloop.scenarios.rerun_log.recorded_points import chunks
from luxloop.scenarios.result import Result

if TYPE_CHECKING:
    import rerun as rr
    import rerun.blueprint as rrb
    from rerun.chunk import Chunk


MISSED, FALSE = "plots/missed", "plots/false"


def log_counts(stream: "rr.RecordingStream", results: Mapping[str, Result], colors: list[Color]) -> None:
    """Log how many graded vehicles each tracker misses, and how many false tracks it has."""
    import rerun as rr

    for path in (MISSED, FALSE):
        stream.log(path, rr.SeriesLines(names=list(results), colors=colors, widths=1.5), static=True)
    truth = next(iter(results.values())).tables["truth"]
    times = truth.drop_duplicates("frame")[["frame", "time_s"]]
    counts = {
        MISSED: [_missed(result) for result in results.values()],
        FALSE: [_false(result) for result in results.values()],
    }
    for frame, time_s in times.itertuples(index=False):
        stream.set_time("frame", sequence=int(frame))
        stream.set_time("sim_time", duration=float(time_s))
        for path, of_trackers in counts.items():
            stream.log(path, rr.Scalars([float(count.get(frame, 0)) for count in of_trackers]))


def _missed(result: Result) -> dict[int, int]:
    truth = result.tables["truth"]
    return _per_frame(truth[truth["graded"] & (truth["track_id"] < 0)])


def _false(result: Result) -> dict[int, int]:
    tracks = result.tables["tracks"]
    return _per_frame(tracks[tracks["verdict"] == "false"])


def _per_frame(rows: pd.DataFrame) -> dict[int, int]:
    count = rows.groupby("frame").size()
    return dict(zip(count.index.tolist(), count.tolist(), strict=True))


RECORDING = "recording.rrd"
OF_ONE_TRACKER = ("/world/odom", "/world/ego/fits", "/plots", "/events", "/legend")
"""Entities of a recording that belong to its own tracker; they are left out."""
POSE_WORLD = ["x_world_m", "y_world_m", "yaw_world_rad"]
LEGEND = f"""\
Bird's-eye view; the **ego is the solid box**, heading up. Circles at {blueprint.RINGS_M[0]:.0f} and
{blueprint.RINGS_M[1]:.0f} m.
- **Truth**: thin white boxes, red when occluded, dim when not graded; the mouse shows the name of a vehicle
- **Tracks**: each tracker has an entity below `world/trackers` and a colour of its own; thick rectangles with the id
  and an arrow of 1 s of travel; thin and dim when coasting
- **Points**: blue on vehicles, grey elsewhere; noise has other colours
"""


def write(runs: "Mapping[str, tuple[Path, Result]]", out: Path) -> None:
    """Write the recording.

    Parameters
    ----------
    runs
        Folder and result of each run, by the name of its tracker.

    Raises
    ------
    InputError
        No run has a recording, whose scans are needed.
    OutputError
        The file cannot be written.
    """
    recordings = [folder / RECORDING for folder, _ in runs.values() if (folder / RECORDING).is_file()]
    if not recordings:
        some = next(iter(runs.values()))[0]
        raise InputError(f"{some}: no {RECORDING} in any of the runs; run one of them without --no-recording")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with atomic_file.create(out) as partial:
            _write(partial, recordings[0], {name: result for name, (_, result) in runs.items()})
    except OSError as error:
        raise OutputError(f"{out}: cannot write there ({error.strerror}); choose another file") from error


def _write(out: Path, recording: Path, results: Mapping[str, Result]) -> None:
    import rerun as rr

    first = next(iter(results.values()))
    stream = rr.RecordingStream("luxloop")
    stream.set_log_time_enabled(False)
    stream.save(out, default_blueprint=_layout())
    stream.send_recording_name(f"{first.scenario}, seed {first.seed}: {len(results)} trackers")
    rr.send_chunks(_common(recording), recording=stream)
    stream.log("legend", rr.TextDocument(LEGEND, media_type=rr.MediaType.MARKDOWN), static=True)
    origin_world = _origin(first)
    for row, (name, result) in enumerate(results.items()):
        _log_tracks(
            stream, f"world/trackers/{row + 1}-{_entity(name)}", result.tables["tracks"], origin_world, _color(row)
        )
    log_counts(stream, results, [_color(row) for row in range(len(results))])
    stream.disconnect()


def _common(recording: Path) -> "Iterator[Chunk]":
    """Yield the chunks of a recording that do not belong to its tracker."""
    for chunk in chunks(recording):
        if not chunk.entity_path.startswith(OF_ONE_TRACKER) and "properties" not in chunk.entity_path:
            yield chunk


def _origin(result: Result) -> Floats:
    """Return the position of the ego in the first frame (3,), which recordings are shifted to; the yaw is 0."""
    start = result.tables["ego"].iloc[0]
    return np.array([start["x_world_m"], start["y_world_m"], 0.0])


def _log_tracks(
    stream: "rr.RecordingStream", path: str, tracks: pd.DataFrame, origin_world: Floats, color: Color
) -> None:
    """Log the tracks of one tracker; a frame without tracks clears those of the frame before."""
    import rerun as rr

    shown = tracks[tracks["status"].isin(("confirmed", "coasting"))]
    by_frame = dict(iter(shown.groupby("frame")))
    for frame, time_s in tracks[["frame", "time_s"]].drop_duplicates("frame").itertuples(index=False):
        rows = by_frame.get(frame, shown.iloc[:0])
        stream.set_time("frame", sequence=int(frame))
        stream.set_time("sim_time", duration=float(time_s))
        pose = rows[POSE_WORLD].to_numpy(np.float64) - origin_world
        solid = (rows["status"] == "confirmed").to_numpy()
        colors = np.array(color) * np.where(solid, 1.0, blueprint.DIM)[:, None]
        size = flat(rows[["length_m", "width_m"]].to_numpy(np.float64))
        ahead = (0.5 * size[:, :1] + blueprint.NAME_GAP_M) * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
        velocity = np.nan_to_num(rows[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64))
        stream.log(path, boxes(pose, size, colors, line_ui=np.where(solid, 2.5, 1.0)))
        stream.log(f"{path}/names", texts(pose[:, :2] + ahead, [str(one) for one in rows["track_id"]]))
        arrows = rr.Arrows3D(origins=flat(pose[:, :2]), vectors=flat(velocity), colors=colors.astype(np.uint8))
        stream.log(f"{path}/velocities", arrows)


def _layout() -> "rrb.Blueprint":
    import rerun.blueprint as rrb

    corner = rrb.Corner2D.LeftTop
    return blueprint.arranged(
        blueprint.scene("Tracks of all trackers"),
        rrb.Vertical(
            rrb.TextDocumentView(origin="legend", name="Legend"),
            rrb.TimeSeriesView(origin=MISSED, name="Graded vehicles without a track", plot_legend=corner),
            rrb.TimeSeriesView(origin=FALSE, name="False tracks", plot_legend=corner),
        ),
    )


def _entity(name: str) -> str:
    """Return the name of a tracker as part of an entity path."""
    return "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in name)


def _color(row: int) -> Color:
    return blueprint.CYCLE[row % len(blueprint.CYCLE)]
