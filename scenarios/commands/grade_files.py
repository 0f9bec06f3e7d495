"""Options and body of `luxloop grade` for two files, without a run."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.scenarios.commands.arguments import finite, require_of

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.paired_frames import BoxLimits

FORMAT_HELP = "Its format: {read_boxes}; recognised if left out."
TruthFormat = Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)]
TracksFormat = Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)]
RangeMax = Annotated[
    float | None,
    typer.Option(metavar="M", callback=finite, help="Leave out boxes farther from the ego; only with --truth."),
]
OccludedMax = Annotated[
    int | None,
    typer.Option(metavar="LEVEL", help="Leave out true boxes of a higher occlusion of KITTI; only with --truth."),
]
Limits = tuple[float, float, int, float | None, int | None]
"""Values of --hit-iou, --gospa-cutoff, --points-min, --range-max and --occluded-max."""
HIT_IOU_MIN, GOSPA_CUTOFF_M = 0.5, 2.0
"""Defaults of `luxloop.scenarios.exchange.paired_frames.BoxLimits`, whose import is slower than the help."""


def grade_files(
    truth: Path | None,
    tracks: Path | None,
    fits: Path | None,
    formats: "tuple[str | None, str | None]",
    classes: str | None,
    given: Limits,
    out: Path | None,
    as_json: bool,
) -> None:
    """Grade a file of tracks, of fits, or both, against a file of true boxes, and print the result.

    Raises
    ------
    InputError
        A file or an option is missing or invalid.
    """
    import json

    from luxloop.scenarios.errors import InputError

    if truth is None or (tracks is None and fits is None):
        raise InputError("give RUN, or both of --truth FILE and --tracks FILE (or --fits FILE)")
    if formats[1] and tracks is None:
        raise InputError("--tracks-format: there are no tracks; give --tracks FILE, or leave it out")
    if out and tracks is None:
        raise InputError("--out: there are no tracks, and fits have no page; give --tracks FILE, or leave it out")
    limits = _limits(given)
    from luxloop.scenarios.exchange import graded_boxes, graded_fits
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.file_document import file_document

    known = _format("--truth-format", formats[0], truth)
    names = tuple(classes.split(",")) if classes is not None else ()
    document, printed = {}, []
    if tracks:
        both = (known, _format("--tracks-format", formats[1], tracks))
        graded = graded_boxes.GradedBoxes.of(truth, tracks, both, names, limits)
        document, printed = graded_boxes.document(graded), [file_document(graded.result)]
        if out:
            graded.result.save(out)
    if fits:
        of_fits = graded_fits.GradedFits.of(truth, fits, known, names, limits)
        document |= {"truth": str(truth), "fits": graded_fits.document(of_fits)}
        printed.append(graded_fits.report(of_fits))
    if as_json:
        print(json.dumps(document, allow_nan=False))
        return
    for report in printed:
        text.show(report)
    if out:
        print(f"Results are in {out}; luxloop report {out}: a page with figures")


def _limits(given: Limits) -> "BoxLimits":
    """Return the limits; an InputError names the first that is out of its range."""
    from luxloop.scenarios.errors import InputError

    hit_iou, gospa_cutoff_m, points_min, range_max_m, occluded_max = given
    if not 0.0 < hit_iou < 1.0:
        raise InputError(f"--hit-iou {hit_iou:g}: should lie between 0 and 1")
    if not 0.0 < gospa_cutoff_m < 1e6:
        raise InputError(f"--gospa-cutoff {gospa_cutoff_m:g}: should be more than 0 and less than 1e6")
    if range_max_m is not None and not 0.0 < range_max_m < 1e6:
        raise InputError(f"--range-max {range_max_m:g}: should be more than 0 and less than 1e6")
    if occluded_max is not None and not 0 <= occluded_max <= 3:
        raise InputError(f"--occluded-max {occluded_max}: should be a level of KITTI, 0 to 3")

    from luxloop.scenarios.exchange.paired_frames import BoxLimits

    return BoxLimits(
        hit_iou_min=hit_iou,
        gospa_cutoff_m=gospa_cutoff_m,
        points_min=points_min,
        range_max_m=range_max_m,
        occluded_max=occluded_max,
    )


def _format(option: str, name: str | None, path: Path) -> str:
    """Return the name of a format, by default that of the content; its packages are installed."""
    from luxloop.scenarios.exchange.file_formats import recognise
    from luxloop.scenarios.files.format_option import format_named

    name = name or recognise(path)
    require_of("grade", format_named(option, name, "read_boxes"))
    return name
