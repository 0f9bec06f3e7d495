"""`luxloop report`."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import Figures


def report(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="RUN...", help="Folders of runs: one run, several trackers on the same drive, or many."),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The page to write; RUN.html, of several report.html, else.")
    ] = None,
    figures: Figures = None,
    latex: Annotated[bool, typer.Option("--latex", help="Also write the tables of a run as LaTeX.")] = False,
    recording: Annotated[
        Path | None,
        typer.Option(metavar="FILE.rrd", help="Also write one recording with the tracks of several trackers."),
    ] = None,
) -> None:
    """Write the report of one run, of several trackers on the same drive, or of many runs as a single HTML file."""
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.report.figure_files import parse_formats
    from luxloop.scenarios.run import run_folder

    formats, single = parse_formats(figures), len(folders) == 1 and (folders[0] / run_folder.RESULT).is_file()
    if (formats or latex) and not single:
        raise InputError(f"{folders[0]}: not one run; --figures and --latex need the folder of a single run")
    out = out or _default_path(folders)
    if single and not recording:
        _report_run(folders[0], out, formats, latex)
    else:
        _report_many(folders, out, recording)
    print(f"The report is in {out}")


def _default_path(folders: list[Path]) -> Path:
    first = folders[0].resolve()
    return first.with_name(f"{first.name}.html" if len(folders) == 1 else "report.html")


def _report_many(folders: list[Path], out: Path, recording: Path | None) -> None:
    """Write the page of several trackers on one drive, with a recording if asked for, or else of all runs."""
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.recording import tracker_recording
    from luxloop.scenarios.report.html import pages
    from luxloop.scenarios.report.html.suite_page import find_runs, suite_page
    from luxloop.scenarios.report.html.tracker_runs import read_trackers, same_drive
    from luxloop.scenarios.report.html.trackers_page import trackers_page

    found = list(dict.fromkeys(run for folder in folders for run in find_runs(folder)))
    if len(folders) > 1 and same_drive(found):
        runs = read_trackers(found)
        if recording:
            tracker_recording.write({name: (run.folder, run.result) for name, run in runs.items()}, recording)
            print(f"The recording is in {recording}; luxloop view {recording} shows it")
        pages.write(out, trackers_page(runs))
    elif recording:
        raise InputError(f"--recording {recording}: needs runs of one scenario and seed by several trackers")
    else:
        pages.write(out, suite_page(found))


def _report_run(folder: Path, out: Path, formats: list[str], latex: bool) -> None:
    """Write the page of a run, and beside it its figures and tables, if asked for: all of them or none."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.files import atomic_file, atomic_folder
    from luxloop.scenarios.report import figure_files
    from luxloop.scenarios.report import latex as latex_tables
    from luxloop.scenarios.report.html import pages, run_page
    from luxloop.scenarios.report.html.reported_run import ReportedRun

    run = ReportedRun.of(interface.load_result(folder), folder)
    shown = run_page.RunFigures.of(run)
    figures, tables = out.with_name(f"{out.stem}-figures"), out.with_name(f"{out.stem}-tables.tex")
    try:
        with figure_files.beside(figures) if formats else nullcontext(), atomic_file.together():
            pages.write(out, run_page.page_of(run, shown))
            paths = [path for figure in shown.files for path in figure_files.save(figure, figures, formats)]
            if latex:
                pages.write(tables, latex_tables.document(run_page.tables_of(run.result), " ".join(run.commands[:1])))
    except OSError as error:
        raise atomic_folder.cannot_write(out, "--out", error) from error
    if formats:
        print(f"{len(paths)} figures are in {figures}")
    if latex:
        print(f"The tables are in {tables}")
