"""HTML report of one run."""

import json
from dataclasses import dataclass
from pathlib import Path

from luxloop.scenarios.report import emergence_rows, own_rows, paper_tables
from luxloop.scenarios.report import fit_tables as printed_fits
from luxloop.scenarios.report import tables as printed
from luxloop.scenarios.report import track_tables as printed_tracks
from luxloop.scenarios.report.figure_files import FigureFile
from luxloop.scenarios.report.html.birdseye import anchors, birdseye
from luxloop.scenarios.report.html.error_figures import COVARIATES, errors_against, errors_by_class, observations
from luxloop.scenarios.report.html.fit_figures import heading_distribution
from luxloop.scenarios.report.html.frame_player import Player, near, player
from luxloop.scenarios.report.html.frame_points import frame_points
from luxloop.scenarios.report.html.page_tables import PageTable, page_table
from luxloop.scenarios.report.html.pages import render
from luxloop.scenarios.report.html.probabilities import model_probabilities
from luxloop.scenarios.report.html.reported_run import ReportedRun
from luxloop.scenarios.report.html.shown_frames import ego_poses, shown_frames
from luxloop.scenarios.report.html.svg_figure import Figure
from luxloop.scenarios.report.html.timelines import timelines
from luxloop.scenarios.report.text import STAGES
from luxloop.scenarios.report.vulnerable_table import vulnerable
from luxloop.scenarios.result import Result

PICTURES, PICTURES_MOST = 8, 14
"""Number of bird's-eye pictures, and the largest one if many metrics failed."""


def run_page(folder: Path) -> str:
    """Return the page of a run folder.

    Raises
    ------
    OutputError
        The folder has no run.
    """
    run = ReportedRun.read(folder)
    return page_of(run, RunFigures.of(run))


def page_of(run: ReportedRun, figures: "RunFigures") -> str:
    """Return the page of a run with these figures."""
    return render(
        "run.html.j2",
        run=run,
        pictures=figures.pictures,
        anchors=anchors(figures.pictures),
        player=figures.player,
        fit_figures=figures.fits,
        fit_tables=fit_tables(run.result),
        track_figures=figures.tracks,
        track_tables=track_tables(run.result),
        band_tables=band_tables(run.result),
        model_figures=figures.models,
        model_tables=model_tables(run.result),
        stage_tables=stage_tables(run.result),
        config=json.dumps(run.result.config, indent=2, ensure_ascii=False),
    )


@dataclass(frozen=True, slots=True)
class RunFigures:
    """Figures of a run by section of its page."""

    pictures: list[Figure]
    player: Player
    fits: list[Figure]
    tracks: list[Figure]
    models: list[Figure]

    @classmethod
    def of(cls, run: ReportedRun) -> "RunFigures":
        """Draw the figures of a run."""
        shown, ego = shown_frames(run.result, run.worst, PICTURES, PICTURES_MOST), ego_poses(run.result)
        points = frame_points(run.folder, run.result, near(shown, ego))
        marked = list(shown.values())
        return cls(
            pictures=birdseye([run.result], run.result.scenario, marked, points),
            player=player({"tracks": run.result}, ego, marked, points),
            fits=fit_figures(run.result),
            tracks=[track_figure(run.result)],
            models=[model_probabilities(run.result.tables["tracks"], run.result.tables["truth"])],
        )

    @property
    def files(self) -> list[FigureFile]:
        """All figures, to be written as files."""
        shown = [*self.pictures, *self.fits, *self.tracks, *self.models]
        return [FigureFile(one.name, one.title, one.size_in, one.paint) for one in shown if one.paint]


def fit_figures(result: Result) -> list[Figure]:
    """Return the figures of fit errors."""
    observed = observations(result.tables["fits"], result.tables["truth"])
    against = [errors_against(observed, covariate) for covariate in COVARIATES]
    return [heading_distribution(result.tables["fits"]), *against, errors_by_class(observed)]


def track_figure(result: Result) -> Figure:
    """Return the figure of timelines."""
    return timelines(result.tables["truth"], result.config["grading"]["hidden_fraction_max"])


def tables_of(result: Result) -> list[PageTable]:
    """Return all tables of a run."""
    return [
        *fit_tables(result),
        *model_tables(result),
        *track_tables(result),
        *band_tables(result),
        *stage_tables(result),
    ]


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


def track_tables(result: Result) -> list[PageTable]:
    """Return the tables of the tracks over the whole run."""
    return [page_table(table) for table in (*printed_tracks.tracking(result), *vulnerable(result))]


def band_tables(result: Result) -> list[PageTable]:
    """Return the tables of the tracks by range, class and view."""
    return [page_table(table) for table in printed_tracks.by_band(result)]


def stage_tables(result: Result) -> list[PageTable]:
    """Return the tables of the other stages, and speed."""
    tables = [
        *emergence_rows.emergence(result),
        *own_rows.own_metrics(result),
        printed.metric_list("Stages of the tracker", result, STAGES),
        printed.outliers(result),
        *([printed.control(result)] if result.config["control"] else []),
        printed.speed(result),
    ]
    return [page_table(table) for table in tables]
