"""Commands that show runs: `luxloop view`, `report`, `paper` and `occlusions`."""

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import AsJson, Figures

if TYPE_CHECKING:
    from luxloop.scenarios.result import Result


def view(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A folder that `luxloop run` wrote, or a recording of `luxloop report`."),
    ],
    frame: Annotated[int | None, typer.Option(help="Start at this frame instead of the worst one.")] = None,
    web: Annotated[bool, typer.Option("--web", help="Open in a browser (starts at the first frame).")] = False,
    analytics: Annotated[
        bool,
        typer.Option("--analytics", help="Let the viewer send statistics of its use, if its own settings allow that."),
    ] = False,
) -> None:
    """Open a run's recording in the rerun viewer, at the worst frame of a failed expectation."""
    from luxloop.scenarios.report.html.reported_run import ReportedRun
    from luxloop.scenarios.rerun_log import viewer
    from luxloop.scenarios.run import run_folder

    recording = run if run.suffix == ".rrd" and run.is_file() else run_folder.recording(run)
    if not web:
        viewer.require_display(run)
    if recording == run:
        raise typer.Exit(viewer.show(recording, None, web=web, analytics=analytics))
    shown = ReportedRun.read(run)
    start = viewer.frame_to_show(shown.result, shown.unmet, frame)
    if start:
        print_text(f"{'Go to' if web else 'Opens at'} {start}")
    raise typer.Exit(viewer.show(recording, start.time_s if start else None, web=web, analytics=analytics))


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
    from luxloop.scenarios.document.figure import parse_formats
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.run import run_folder

    formats, single = parse_formats(figures), len(folders) == 1 and (folders[0] / run_folder.RESULT).is_file()
    if (formats or latex) and not single:
        raise InputError(f"{folders[0]}: not one run; --figures and --latex need the folder of a single run")
    out = out or _default_path(folders)
    if single and not recording:
        _report_run(folders[0], out, formats, latex)
    else:
        _report_many(folders, out, recording)
    print_text(f"The report is in {out}")


def _default_path(folders: list[Path]) -> Path:
    first = folders[0].resolve()
    return first.with_name(f"{first.name}.html" if len(folders) == 1 else "report.html")


def _report_many(folders: list[Path], out: Path, recording: Path | None) -> None:
    """Write the page of several trackers on one drive, with a recording if asked for, or else of all runs."""
    from luxloop.scenarios.document import html
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.report.html.suite_page import find_runs, suite_page
    from luxloop.scenarios.report.html.trackers_page import read_trackers, same_drive, trackers_page
    from luxloop.scenarios.rerun_log import tracker_recording

    found = list(dict.fromkeys(run for folder in folders for run in find_runs(folder)))
    if len(folders) > 1 and same_drive(found):
        runs = read_trackers(found)
        if recording:
            tracker_recording.write({name: (run.folder, run.result) for name, run in runs.items()}, recording)
            print_text(f"The recording is in {recording}; luxloop view {recording} shows it")
        html.write(out, trackers_page(runs))
    elif recording:
        raise InputError(f"--recording {recording}: needs runs of one scenario and seed by several trackers")
    else:
        html.write(out, suite_page(found))


def _report_run(folder: Path, out: Path, formats: list[str], latex: bool) -> None:
    """Write the page of a run, and beside it its figures and tables, if asked for: all of them or none."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.document import html
    from luxloop.scenarios.document import latex as latex_tables
    from luxloop.scenarios.document.figure import beside
    from luxloop.scenarios.files import atomic_file
    from luxloop.scenarios.report.html.reported_run import ReportedRun
    from luxloop.scenarios.report.html.run_page import run_figures
    from luxloop.scenarios.report.run_document import run_document

    run = ReportedRun.of(interface.load_result(folder), folder)
    shown = run_document(run, run_figures(run))
    figures, tables = out.with_name(f"{out.stem}-figures"), out.with_name(f"{out.stem}-tables.tex")
    with atomic_file.writing(out), beside(figures) if formats else nullcontext(), atomic_file.together():
        html.write(out, shown)
        paths = [path for figure in shown.figures for path in figure.save(figures, formats)]
        if latex:
            atomic_file.save_text(tables, latex_tables.latex(shown.tables, " ".join(run.commands[:1])))
    if formats:
        print_text(f"{len(paths)} figures are in {figures}")
    if latex:
        print_text(f"The tables are in {tables}")


SCENARIO = "paper-campus"
"""The surrogate of the paper's drive."""
PAPERS_STEPS = "the paper's steps"


def paper(
    runs: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[RUN...]",
            help=f"Folders of luxloop run, a column each; if left out, {SCENARIO} by the paper's own steps and by the "
            "default tracker, run if missing.",
        ),
    ] = None,
    table: Annotated[int | None, typer.Option(min=1, max=4, help="Only this table of the paper.")] = None,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX, for the package booktabs.")] = False,
) -> None:
    """Print the paper's tables I to IV: its own figures beside those of runs, and whether they are reproduced."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.document.document import Answer, Document, Section
    from luxloop.scenarios.document.latex import latex as latex_of
    from luxloop.scenarios.report import paper_comparison, run_document, text

    results = {str(run): interface.load_result(run) for run in runs} if runs else _papers_runs()
    sources = {name: result.metrics for name, result in results.items()}
    makers = paper_comparison.TABLES if table is None else paper_comparison.TABLES[table - 1 : table]
    shown = [make(sources) for make in makers]
    name, result = next(iter(results.items()))
    if latex:
        print_text(latex_of(shown, f"{result.scenario}, seed {result.seed}"), end="")
    else:
        answer = Answer(paper_comparison.verdict(name, result.metrics).rstrip("."))
        tables = [Section("paper", "The paper's tables", shown)]
        text.show(Document(result.scenario, answer, run_document.header(result), tables))


def _papers_runs() -> "dict[str, Result]":
    """Return the runs of the paper's scenario by the paper's steps and by the default tracker, run if missing."""
    from luxloop.scenarios import interface
    from luxloop.scenarios.execute import default_folder
    from luxloop.scenarios.run import run_folder

    scenario, results = interface.load_scenario(SCENARIO), {}
    for name, tracker in ((PAPERS_STEPS, "paper"), ("default", None)):
        out = default_folder(scenario, tracker=tracker)
        is_there = (out / run_folder.RESULT).is_file()
        results[name] = (
            interface.load_result(out)
            if is_there
            else interface.run(scenario, tracker=tracker, out=out, ahead=False, progress=True)
        )
    return results


def occlusions(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Folders that `luxloop run` wrote, or folders of these.")
    ],
    out: Annotated[Path | None, typer.Option(help="Folder of the table of all occlusions, figures and JSON.")] = None,
    figures: Figures = None,
    as_json: AsJson = False,
) -> None:
    """Survival of track ids against the time hidden, over all occlusions of some runs, by logistic regression."""
    import json

    from luxloop.scenarios.document.document import json_data
    from luxloop.scenarios.document.figure import parse_formats
    from luxloop.scenarios.report import text
    from luxloop.scenarios.study import occlusion_survival

    formats = parse_formats(figures)
    found = occlusion_survival.regress(occlusion_survival.read(runs))
    if out:
        occlusion_survival.write(found, out, formats)
    shown = occlusion_survival.document(found)
    if as_json:
        print_text(json.dumps({**json_data(shown), "out": out and str(out)}, allow_nan=False))
    else:
        text.show(shown)
        print_text(
            f"Table and figure are in {out}" if out else "Nothing was written; for the table and a figure, give --out"
        )
