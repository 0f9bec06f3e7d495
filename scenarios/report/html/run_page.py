"""HTML report of one run."""

import json
from pathlib import Path

from scenarios.report import emergence_rows, own_rows, paper_tables
from scenarios.report import fit_tables as printed_fits
from scenarios.report import tables as printed
from scenarios.report import track_tables as printed_tracks
from scenarios.report.html.birdseye import birdseye
from scenarios.report.html.fit_figures import COVARIATES, errors_against, heading_distribution, observations
from scenarios.report.html.page_tables import PageTable, page_table
from scenarios.report.html.pages import render
from scenarios.report.html.probabilities import model_probabilities
from scenarios.report.html.reported_run import ReportedRun
from scenarios.report.html.svg_figure import Figure
from scenarios.report.html.timelines import timelines
from scenarios.report.text import STAGES
from scenarios.result import Result


def run_page(folder: Path) -> str:
    """Return the page of a run folder.

    Raises
    ------
    OutputError
        The folder has no run.
    """
    run = ReportedRun.read(folder)
    return render(
        "run.html.j2",
        run=run,
        pictures=birdseye(run.result, run.result.scenario, run.unmet),
        fit_figures=fit_figures(run.result),
        fit_tables=fit_tables(run.result),
        track_figures=[track_figure(run.result)],
        model_figures=[model_probabilities(run.result.tables["tracks"])],
        model_tables=model_tables(run.result),
        stage_tables=stage_tables(run.result),
        config=json.dumps(run.result.config, indent=2, ensure_ascii=False),
    )


def fit_figures(result: Result) -> list[Figure]:
    """Return the figures of fit errors."""
    observed = observations(result.tables["fits"], result.tables["truth"])
    against = [errors_against(observed, covariate) for covariate in COVARIATES]
    return [heading_distribution(result.tables["fits"]), *against]


def track_figure(result: Result) -> Figure:
    """Return the figure of timelines."""
    return timelines(result.tables["truth"], result.config["grading"]["hidden_fraction_max"])


def fit_tables(result: Result) -> list[PageTable]:
    """Return the paper's tables I to III, and those of the fits."""
    tables = (
        paper_tables.dataset(result),
        paper_tables.heading_error(result),
        paper_tables.heading_distribution(result),
        paper_tables.heading_by_view(result),
        printed_fits.heading_by_band(result),
        printed_fits.selection(result),
        printed_fits.corner_and_extents(result),
    )
    return [page_table(table) for table in tables]


def model_tables(result: Result) -> list[PageTable]:
    """Return the paper's table IV, and the tables of modes and consistency."""
    return [page_table(table(result)) for table in (paper_tables.position_error, printed.modes, printed.consistency)]


def stage_tables(result: Result) -> list[PageTable]:
    """Return the tables of tracking, the other stages, and speed."""
    tables = [
        *printed_tracks.tracking(result),
        *printed_tracks.by_band(result),
        *emergence_rows.emergence(result),
        *own_rows.own_metrics(result),
        printed.metric_list("Stages of the tracker", result, STAGES),
        printed.outliers(result),
        *([printed.control(result)] if result.config["control"] else []),
        printed.speed(result),
    ]
    return [page_table(table) for table in tables]
