"""`luxloop report`."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.commands.arguments import Figures


def report(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run, or a folder of many runs.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="The page to write; RUN.html if left out.")] = None,
    figures: Figures = None,
    latex: Annotated[bool, typer.Option("--latex", help="Also write the tables of a run as LaTeX.")] = False,
) -> None:
    """Write the report of one run or many as a single HTML file; of one run also its figures and tables as files."""
    from scenarios.errors import InputError
    from scenarios.report.figure_files import parse_formats
    from scenarios.report.html import pages
    from scenarios.report.html.suite_page import find_runs, suite_page
    from scenarios.run import run_folder

    formats, is_run = parse_formats(figures), (folder / run_folder.RESULT).is_file()
    out = out or folder.resolve().with_name(f"{folder.resolve().name}.html")
    if is_run:
        _report_run(folder, out, formats, latex)
    elif formats or latex:
        raise InputError(f"{folder}: not one run; --figures and --latex need the folder of a single run")
    else:
        pages.write(out, suite_page(find_runs(folder)))
    print(f"The report is in {out}")


def _report_run(folder: Path, out: Path, formats: list[str], latex: bool) -> None:
    """Write the page of a run, and beside it its figures and tables, if asked for."""
    from scenarios.report import figure_files
    from scenarios.report import latex as latex_tables
    from scenarios.report.html import pages, run_page
    from scenarios.report.html.reported_run import ReportedRun

    run = ReportedRun.read(folder)
    shown = run_page.RunFigures.of(run)
    pages.write(out, run_page.page_of(run, shown))
    if formats:
        beside = out.with_name(f"{out.stem}-figures")
        figure_files.make_folder(beside)
        paths = [path for figure in shown.files for path in figure_files.save(figure, beside, formats)]
        print(f"{len(paths)} figures are in {beside}")
    if latex:
        beside = out.with_name(f"{out.stem}-tables.tex")
        pages.write(beside, latex_tables.document(run_page.tables_of(run.result), " ".join(run.commands[:1])))
        print(f"The tables are in {beside}")
