"""Figures and page of one run."""

from pathlib import Path

from luxloop.scenarios.document.document import Document
from luxloop.scenarios.document.figure import Figure
from luxloop.scenarios.report.html.birdseye import birdseye
from luxloop.scenarios.report.html.frame_player import near, player
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.run_figures import (
    COVARIATES,
    errors_against,
    errors_by_class,
    heading_distribution,
    model_probabilities,
    observations,
)
from luxloop.scenarios.report.html.shown_frames import ego_poses, frame_points, shown_frames
from luxloop.scenarios.report.html.timelines import file_figures, timelines
from luxloop.scenarios.report.run_document import RunFigures, run_document
from luxloop.scenarios.result import Result

PICTURES, PICTURES_MOST = 8, 14
"""Number of bird's-eye pictures, and the largest one if many metrics failed."""


def run_page(folder: Path) -> Document:
    """Return the page of a run folder.

    Raises
    ------
    OutputError
        The folder has no run.
    """
    run = ReportedRun.read(folder)
    return run_document(run, run_figures(run))


def run_figures(run: ReportedRun) -> RunFigures:
    """Return the figures of a run."""
    result = run.result
    if "files" in result.config:
        return RunFigures(tracks=file_figures(result))
    shown, ego = shown_frames(result, run.worst, PICTURES, PICTURES_MOST), ego_poses(result)
    points = frame_points(run.folder, result, near(shown, ego))
    marked = list(shown.values())
    return RunFigures(
        pictures=birdseye([result], result.scenario, marked, points),
        player=player({"tracks": result}, ego, marked, points) if ego else None,
        fits=fit_figures(result),
        tracks=[timelines(result.tables["truth"], result.config["grading"]["hidden_fraction_max"])],
        models=[model_probabilities(result.tables["tracks"], result.tables["truth"])],
    )


def fit_figures(result: Result) -> list[Figure]:
    """Return the figures of fit errors."""
    observed = observations(result.tables["fits"], result.tables["truth"])
    against = [errors_against(observed, covariate) for covariate in COVARIATES]
    return [heading_distribution(result.tables["fits"]), *against, errors_by_class(observed)]
