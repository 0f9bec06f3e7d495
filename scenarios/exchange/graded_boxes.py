"""Grading of a file of tracks against a file of true boxes: a result like that of a run, and its JSON document."""

import hashlib
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from luxloop.scenarios.exchange import file_tables
from luxloop.scenarios.exchange.box_table import IMAGE_AXES, BoxTable
from luxloop.scenarios.exchange.file_formats import read
from luxloop.scenarios.exchange.file_tables import tables_of
from luxloop.scenarios.exchange.paired_frames import (
    BoxLimits,
    FrameMatching,
    FramePairs,
    about_the_ego,
    in_common_axes,
    of_classes,
    pair_frames,
    require_common_frames,
    unpaired,
)
from luxloop.scenarios.grading.figures import Figures
from luxloop.scenarios.grading.observations import RunObservations
from luxloop.scenarios.metrics import main_figures, of_files
from luxloop.scenarios.metrics.definition import filtered
from luxloop.scenarios.report.file_document import BANDED, bands
from luxloop.scenarios.result import Result
from luxloop.scenarios.run import versions
from luxloop.scenarios.run.run_folder import metric_document


def grade(
    truth: Path,
    tracks: Path,
    formats: tuple[str | None, str | None],
    classes: tuple[str, ...],
    limits: BoxLimits,
    matching: FrameMatching | None = None,
) -> Result:
    """Read both files and grade the tracks.

    Raises
    ------
    TracksError
        A file is not valid, or they do not belong together.
    """
    image = limits.kitti is not None
    found = [read(truth, "truth", formats[0], image=image), read(tracks, "tracks", formats[1], image=image)]
    if limits.range_max_m is not None:
        found = [about_the_ego(of_file) for of_file in found]
    tables = in_common_axes(found[0], found[1])
    matching = matching or FrameMatching()
    alone = unpaired(pair_frames(*tables, matching), matching)
    warnings = (*_warnings(*tables, bool(classes or limits.kitti)), *([alone] if alone else []))
    if classes:
        tables = of_classes(*tables, list(classes))
    if limits.kitti:
        tables = file_tables.of_class(*tables, limits.kitti)
    pairs = pair_frames(*tables, matching)
    require_common_frames(pairs)
    result = _result(pairs, limits, classes, warnings)
    result.config["files"] |= {"frames": asdict(matching), "scenes": _of_scenes(*tables, limits, matching)}
    return result


def _of_scenes(truth: BoxTable, tracks: BoxTable, limits: BoxLimits, matching: FrameMatching) -> dict[str, Any]:
    """Return the main figures of each scene by its name; none for files without scenes."""
    found: dict[str, Any] = {}
    for scene in [] if truth.scene is None or tracks.scene is None else np.unique(truth.scene).tolist():
        parts = (truth.select(truth.scene == scene), tracks.select(tracks.scene == scene))
        metrics = _result(pair_frames(*parts, matching), limits, (), ()).metrics
        found[scene] = {name: metrics[name].value for name in main_figures.OF_FILES}
    return found


def document(result: Result) -> dict[str, Any]:
    """Return a grading as JSON."""
    metrics, files = result.metrics, result.config["files"]
    by_band = {filtered(name, **band): metrics.where(name, **band) for band in bands(result) for name in BANDED}
    return {
        "truth": files["truth"],
        "tracks": result.config["device"],
        "frames": result.frames,
        "true_boxes": len(metrics.run.vehicle),
        "track_boxes": len(metrics.run.clear.tracks),
        "limits": files["limits"],
        "frame_matching": files["frames"],
        "scenes": files["scenes"],
        "classes": files["classes"],
        "warnings": list(result.warnings),
        "metrics": {name: metric_document(metric) for name, metric in {**metrics, **by_band}.items()},
    }


def _result(pairs: FramePairs, limits: BoxLimits, classes: tuple[str, ...], warnings: tuple[str, ...]) -> Result:
    """Return the result of a grading; it is the drive of the truth, by the tracks as the device."""
    missing, tables = _missing(pairs), tables_of(pairs, limits)
    run = RunObservations(tables, limits.grading, pairs.frames)
    truth, tracks = pairs.truth.source, pairs.tracks.source
    return Result(
        scenario=truth.name,
        seed=0,
        trace_hash=_hash(pairs),
        ended_early="",
        simulator_failed=False,
        frames=pairs.frames,
        metrics=Figures(run, {}, of_files.why_not(missing), of_files.NAMES),
        tables=tables,
        config={
            "description": f"Tracks of {tracks} against true boxes of {truth}.",
            "reason": "",
            "files": {"truth": str(truth), "limits": asdict(limits), "classes": list(classes)},
            "missing": missing,
            "grading": asdict(limits.grading),
            "expect": {},
            "control": None,
            "device": str(tracks),
        },
        versions=versions.installed(),
        warnings=warnings,
    )


def _missing(pairs: FramePairs) -> dict[str, str]:
    """Return the reasons of metrics and filters that need more than the files have."""
    both, truth, tracks = (pairs.truth, pairs.tracks), (pairs.truth,), (pairs.tracks,)
    needed: dict[str, tuple[str, str, Iterable[BoxTable]]] = {
        "motion": ("velocity", "velocities", truth),
        "velocity": ("velocity", "velocities", both),
        "height": ("height_m", "heights", both),
        "score": ("score", "scores", tracks),
        "time": ("time_s", "times", both),
        "points": ("points", "numbers of points", truth),
        "class": ("kind", "classes", truth),
    }
    found: dict[str, str] = {}
    for name, (column, what, tables) in needed.items():
        for table in tables:
            if getattr(table, column) is None:
                found.setdefault(name, f"{table.source.name} has no {what}")
    found["view"] = "visible sides are not known in files of boxes"
    if pairs.truth.axes == IMAGE_AXES:
        found["metres"] = "boxes in the image have no metres"
    return found if pairs.about_ego else {**found, "range": "the positions are not about the ego"}


def _warnings(truth: BoxTable, tracks: BoxTable, some_classes: bool) -> tuple[str, ...]:
    """Return what the numbers do not show: classes of tracks that the truth does not have, such as misspelt ones."""
    if truth.kind is None or tracks.kind is None:
        return ()
    unknown = ", ".join(sorted(set(tracks.kind.tolist()) - set(truth.kind.tolist())))[:300]
    left_out = "left out" if some_classes else "left out of AMOTA and AMOTP"
    return (f"the truth has no class {unknown}: tracks of it are {left_out}",) if unknown else ()


def _hash(pairs: FramePairs) -> str:
    """Return the hash of the boxes of both files."""
    digest = hashlib.blake2b(digest_size=16)
    for table, frame, number in (
        (pairs.truth, pairs.truth_frame, pairs.truth_id),
        (pairs.tracks, pairs.track_frame, pairs.track_id),
    ):
        for column in (table.boxes, frame, number):
            digest.update(column.tobytes())
    return digest.hexdigest()
