"""Options and body of `luxloop grade` for two files, without a run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from scenarios.commands.extras import require

if TYPE_CHECKING:
    from scenarios.exchange.file_formats import Format

FORMAT_HELP = "Its format: csv, parquet, kitti, nuscenes, mcap, osi; recognised if left out."
TruthFormat = Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)]
TracksFormat = Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)]
HIT_IOU_MIN, GOSPA_CUTOFF_M = 0.5, 2.0
"""Defaults of `scenarios.exchange.box_grading.BoxLimits`, whose import is slower than the help."""


def grade_files(
    truth: Path | None,
    tracks: Path | None,
    formats: "tuple[str | None, str | None]",
    classes: str | None,
    hit_iou: float,
    gospa_cutoff_m: float,
    points_min: int,
    as_json: bool,
) -> None:
    """Grade a file of tracks against a file of true boxes, and print the result.

    Raises
    ------
    InputError
        A file or an option is missing or invalid.
    """
    import json

    from scenarios.errors import InputError

    if truth is None or tracks is None:
        raise InputError("give RUN, or both of --truth FILE and --tracks FILE")
    if not 0.0 < hit_iou < 1.0:
        raise InputError(f"--hit-iou {hit_iou:g}: should lie between 0 and 1")
    if not 0.0 < gospa_cutoff_m < 1e6:
        raise InputError(f"--gospa-cutoff {gospa_cutoff_m:g}: should be more than 0 and less than 1e6")
    from scenarios.exchange import graded_boxes
    from scenarios.exchange.box_grading import BoxLimits
    from scenarios.report import text

    known = (_format("--truth-format", formats[0], truth), _format("--tracks-format", formats[1], tracks))
    names = tuple(classes.split(",")) if classes is not None else ()
    limits = BoxLimits(hit_iou_min=hit_iou, gospa_cutoff_m=gospa_cutoff_m, points_min=points_min)
    graded = graded_boxes.GradedBoxes.of(truth, tracks, known, names, limits)
    if as_json:
        print(json.dumps(graded_boxes.document(graded), allow_nan=False))
    else:
        text.show(graded_boxes.report(graded))


def _format(option: str, name: str | None, path: Path) -> "Format":
    """Return a format by its name, or that of the content; MCAP and OSI need their packages."""
    from scenarios.errors import InputError
    from scenarios.exchange.file_formats import FORMATS, recognise

    found = next((known for known in FORMATS if known == name), None)
    if name is not None and found is None:
        raise InputError(f"{option} {name}: is none of {', '.join(FORMATS)}")
    found = found or recognise(path)
    if found in ("mcap", "osi"):
        require("grade", found)
    return found
