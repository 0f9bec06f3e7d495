"""`luxloop occlusions`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import AsJson, Figures


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

    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.figure_files import parse_formats
    from luxloop.scenarios.study import occlusion_report, occlusion_survival

    formats = parse_formats(figures)
    found = occlusion_survival.regress(occlusion_survival.read(runs))
    if out:
        occlusion_report.write(found, out, formats)
    if as_json:
        print(json.dumps({**occlusion_report.document(found), "out": out and str(out)}, allow_nan=False))
    else:
        text.show(occlusion_report.report(found))
        print(
            f"Table and figure are in {out}" if out else "Nothing was written; for the table and a figure, give --out"
        )
