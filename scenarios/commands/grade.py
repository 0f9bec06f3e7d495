"""`luxloop grade`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import (
    DEFAULT_STEP_TIMEOUT_S,
    AsJson,
    Full,
    StepTimeout,
    finite,
    given,
    grouped,
    require_of,
)

if TYPE_CHECKING:
    from luxloop.scenarios.exchange.paired_frames import BoxLimits, FrameMatching
    from luxloop.scenarios.result import Result


FORMAT_HELP = "Its format: {read_boxes}; recognised if left out."
HIT_IOU_MIN, GOSPA_CUTOFF_M, TIME_TOLERANCE_S = 0.5, 2.0, 1e-3
"""Defaults of `luxloop.scenarios.exchange.paired_frames`, whose import is slower than the help."""


@dataclass(frozen=True, slots=True)
class BoxFiles:
    """Options of a grading of files."""

    truth: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of true boxes, instead of RUN; see docs/formats.md.")
    ] = None
    fits: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File of rectangles fitted to single frames; only with --truth."),
    ] = None
    truth_format: Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)] = None
    tracks_format: Annotated[str | None, typer.Option(metavar="FORMAT", help=FORMAT_HELP)] = None
    classes: Annotated[
        str | None, typer.Option(metavar="NAME,...", help="Classes of the truth to grade; only with --truth.")
    ] = None
    hit_iou: Annotated[
        float,
        typer.Option(
            metavar="IOU", callback=finite, help="Least overlap of a hit of MOTA and IDF1; only with --truth."
        ),
    ] = HIT_IOU_MIN
    gospa_cutoff: Annotated[
        float, typer.Option(metavar="M", callback=finite, help="Cut-off distance c of GOSPA; only with --truth.")
    ] = GOSPA_CUTOFF_M
    points_min: Annotated[
        int, typer.Option(metavar="N", min=0, help="Leave out true boxes of fewer points; only with --truth.")
    ] = 0
    range_max: Annotated[
        float | None,
        typer.Option(metavar="M", callback=finite, help="Leave out boxes farther from the ego; only with --truth."),
    ] = None
    occluded_max: Annotated[
        int | None,
        typer.Option(metavar="LEVEL", help="Leave out true boxes of a higher occlusion of KITTI; only with --truth."),
    ] = None
    kitti: Annotated[
        str | None,
        typer.Option(
            metavar="CLASS", help="Grade the boxes in the image by KITTI's rules: car or pedestrian; with --truth."
        ),
    ] = None
    time_tolerance: Annotated[
        float,
        typer.Option(metavar="S", min=0.0, callback=finite, help="Times of one frame differ by less; with --truth."),
    ] = TIME_TOLERANCE_S
    time_offset: Annotated[
        float, typer.Option(metavar="S", callback=finite, help="Added to the times of the tracks; only with --truth.")
    ] = 0.0
    frame_offset: Annotated[
        int, typer.Option(metavar="N", help="Added to the numbers of frames of the tracks; only with --truth.")
    ] = 0
    common_frames: Annotated[
        bool, typer.Option("--common-frames", help="Grade only frames of both files; only with --truth.")
    ] = False

    def matching(self) -> "FrameMatching":
        """Return which frames of the files are the same."""
        from luxloop.scenarios.exchange.paired_frames import FrameMatching

        return FrameMatching(self.time_tolerance, self.time_offset, self.frame_offset, self.common_frames)

    def limits(self) -> "BoxLimits":
        """Return the limits; an InputError names the first that is out of its range."""
        from luxloop.scenarios.errors import InputError

        if not 0.0 < self.hit_iou < 1.0:
            raise InputError(f"--hit-iou {self.hit_iou:g}: should lie between 0 and 1")
        if not 0.0 < self.gospa_cutoff < 1e6:
            raise InputError(f"--gospa-cutoff {self.gospa_cutoff:g}: should be more than 0 and less than 1e6")
        if self.range_max is not None and not 0.0 < self.range_max < 1e6:
            raise InputError(f"--range-max {self.range_max:g}: should be more than 0 and less than 1e6")
        if self.occluded_max is not None and not 0 <= self.occluded_max <= 3:
            raise InputError(f"--occluded-max {self.occluded_max}: should be a level of KITTI, 0 to 3")
        if self.kitti and (self.fits or self.classes or self._has_limits()):
            raise InputError(
                f"--kitti {self.kitti}: has the limits of the benchmark; leave other limits and --fits out"
            )

        from luxloop.scenarios.exchange.paired_frames import BoxLimits

        return BoxLimits(
            hit_iou_min=self.hit_iou,
            gospa_cutoff_m=self.gospa_cutoff,
            points_min=self.points_min,
            range_max_m=self.range_max,
            occluded_max=self.occluded_max,
            kitti=self.kitti,
        )

    def _has_limits(self) -> bool:
        return (
            self.hit_iou != HIT_IOU_MIN
            or self.points_min > 0
            or self.range_max is not None
            or self.occluded_max is not None
        )


def grade_files(tracks: Path | None, files: BoxFiles, out: Path | None, as_json: bool) -> None:
    """Grade a file of tracks, of fits, or both, against a file of true boxes, and print the result.

    Raises
    ------
    InputError
        A file or an option is missing or invalid.
    """
    import json

    from luxloop.scenarios.errors import InputError

    truth = files.truth
    if truth is None or (tracks is None and files.fits is None):
        raise InputError("give RUN, or both of --truth FILE and --tracks FILE (or --fits FILE)")
    if files.tracks_format and tracks is None:
        raise InputError("--tracks-format: there are no tracks; give --tracks FILE, or leave it out")
    if out and tracks is None:
        raise InputError("--out: there are no tracks, and fits have no page; give --tracks FILE, or leave it out")
    limits = files.limits()
    from luxloop.scenarios import interface
    from luxloop.scenarios.exchange import graded_boxes, graded_fits
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.file_document import file_document

    known = _format("--truth-format", files.truth_format, truth)
    classes = tuple(files.classes.split(",")) if files.classes is not None else ()
    document, printed = {}, []
    if tracks:
        formats = (known, _format("--tracks-format", files.tracks_format, tracks))
        result = interface.grade_boxes(
            truth, tracks, formats=formats, classes=classes, limits=limits, matching=files.matching()
        )
        document, printed = graded_boxes.document(result), [file_document(result)]
        if out:
            result.save(out)
    if files.fits:
        of_fits = graded_fits.GradedFits.of(truth, files.fits, known, classes, limits)
        document |= {"truth": str(truth), "fits": graded_fits.document(of_fits)}
        printed.append(graded_fits.report(of_fits))
    if as_json:
        print_text(json.dumps(document, allow_nan=False))
        return
    for report in printed:
        text.show(report)
    if out:
        print_text(f"Results are in {out}; luxloop report {out}: a page with figures")


def _format(option: str, name: str | None, path: Path) -> str:
    """Return the name of a format, by default that of the content; its packages are installed."""
    from luxloop.scenarios.exchange.file_formats import recognise
    from luxloop.scenarios.files.option_values import format_named

    name = name or recognise(path)
    require_of("grade", format_named(option, name, "read_boxes"))
    return name


NO_FILES = BoxFiles()


@grouped
def grade(
    run: Annotated[
        Path | None, typer.Argument(metavar="RUN", help="A folder that `luxloop run` or `luxloop import` wrote.")
    ] = None,
    tracks: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of tracks that another program made from the run's scans.")
    ] = None,
    files: BoxFiles = NO_FILES,
    tracker: Annotated[
        str | None,
        typer.Option(metavar="MODULE:NAME", help="A tracker to run on the scans, as for luxloop run."),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(metavar="SCENARIO", help="Scenario whose [grading] and [expect] replace the run's."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; if left out, they are only printed.")] = None,
    as_json: AsJson = False,
    full: Full = False,
    step_timeout: StepTimeout = DEFAULT_STEP_TIMEOUT_S,
) -> None:
    """Grade a run again without simulation, a recording with true poses, or any tracks against any truth in files."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.files.expect import exit_code

    if tracks and tracker:
        raise InputError("--tracks and --tracker are both given; give one, or none for the run's own tracks")
    either = "give either RUN, or --truth FILE and --tracks FILE"
    if run is None:
        for name, value in {"--tracker": tracker, "--scenario": scenario}.items():
            if value is not None:
                raise InputError(f"{name} needs RUN; {either}")
        grade_files(tracks, files, out, as_json)
        return
    for name in given(files):
        raise InputError(f"{name} cannot be given with RUN; {either}")
    result = interface.grade(
        run, tracks=tracks, tracker=tracker, scenario=scenario, out=out, step_timeout_s=step_timeout
    )
    _print(result, run, as_json, full)
    raise typer.Exit(exit_code(result.verdict))


def _print(result: "Result", run: Path, as_json: bool, full: bool) -> None:
    """Print the document, the first screen or the full report."""
    import json

    from luxloop.scenarios.report import first_screen, text
    from luxloop.scenarios.run import run_folder

    checks, out = result.checks, result.out
    if as_json:
        print_text(json.dumps({**run_folder.document(result, checks), "out": out and str(out)}, allow_nan=False))
    elif full:
        text.show(text.report(result, checks))
        print_text(f"Results are in {out}" if out else "Nothing was written; to keep it, give --out")
    elif out:
        first_screen.show_folder(result, checks, out, recorded=False)
    else:
        keep = {f"luxloop grade {run} --out DIR": "nothing was written; this keeps it"}
        first_screen.show(result, checks, keep, "--full prints the whole report")
