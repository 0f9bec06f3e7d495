"""Commands for own data and other programs: `luxloop egos`, `new`, `export`, `mcap`, `realism` and `fits`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import AsJson, Quiet, RunFolder, finite, require, require_of
from luxloop.sim.candidates.want import Want

Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="A SUMO net with routes beside it, a .sumocfg, a folder with one of these, or a scenario with SUMO "
        "traffic.",
    ),
]
Routes = Annotated[
    list[Path] | None,
    typer.Option(help="Route file of a net, or a folder of them; may be repeated. Else those beside it."),
]
Begin = Annotated[
    float | None, typer.Option(min=0.0, callback=finite, help="Start of SUMO's clock [s], as the key begin_s.")
]
Window = Annotated[float, typer.Option(min=1.0, callback=finite, help="Simulated time of the survey [s].")]


def egos(
    source: Source,
    want: Annotated[Want, typer.Option(help="What the best candidate has most of.")] = Want.NEIGHBOURS,
    routes: Routes = None,
    begin: Begin = None,
    window: Window = 300.0,
    stay: Annotated[float, typer.Option(min=0.0, callback=finite, help="Shorter stays [s] come last.")] = 30.0,
    top: Annotated[int, typer.Option(min=1, help="Largest number of candidates.")] = 20,
    any_class: Annotated[
        bool, typer.Option("--any-class", help="Also list what cannot carry the rig: trams, trains, bicycles.")
    ] = False,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the traffic.")] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """List candidates for the ego in SUMO traffic, with their stay, neighbours, turns, stops and occlusions."""
    import json

    from luxloop.scenarios.authoring import ego_survey
    from luxloop.scenarios.report import text
    from luxloop.scenarios.run.progress import hidden

    with hidden(quiet or as_json):
        survey = ego_survey.survey_source(source, routes or [], begin, window, seed)
    found = survey.candidates
    rows = [int(row) for row in found.order(want, stay) if any_class or not found.bodies[row].rejected][:top]
    if as_json:
        entries = [ego_survey.document(found, row) for row in rows]
        head = {"source": source, "want": want.value, "left_out": survey.left_out, "vehicles": len(found)}
        print_text(json.dumps({**head, "candidates": entries}))
    else:
        text.show(ego_survey.candidates_document(survey, rows, want, source))


def new(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="A SUMO net with routes beside it, a .sumocfg, a folder with one of these, a recording, or the id of "
            "an environment of highway-env.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE.toml", help="The scenario file to write.")],
    duration: Annotated[
        float, typer.Option(min=3.0, callback=finite, help="Simulated seconds of the scenario.")
    ] = 30.0,
    want: Annotated[Want, typer.Option(help="What the ego has most of, see luxloop egos.")] = Want.NEIGHBOURS,
    ego: Annotated[str, typer.Option(help="Id of the ego; chosen if left out.")] = "",
    routes: Routes = None,
    begin: Begin = None,
    window: Window = 300.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the scenario.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Write a scenario file for some traffic: choose ego and window, check them, and say why."""
    import json

    from luxloop.scenarios.authoring.draft import DraftOptions
    from luxloop.scenarios.authoring.new_scenario import write_scenario
    from luxloop.scenarios.run.progress import hidden

    options = DraftOptions(out, duration, seed, want, ego, begin, window)
    with hidden(quiet or as_json):
        choices = write_scenario(source, routes or [], options, force=force)
    if as_json:
        print_text(json.dumps({"out": str(out), "choices": choices}))
    elif not quiet:
        print_text("\n".join(choices))
        print_text(f"Its limits are generic defaults: adapt them. To run it: luxloop run {out}")


def export(
    run: RunFolder,
    folder_format: Annotated[str, typer.Option("--format", metavar="FORMAT", help="One of {export}.")],
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="The folder to write; it must not exist.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as a folder in the format of other programs."""
    from luxloop.scenarios.exchange.exported_run import write_folder
    from luxloop.scenarios.files.option_values import format_named
    from luxloop.scenarios.offline.recorded_scans import RecordedRun
    from luxloop.scenarios.report.cells import counted

    chosen = format_named("--format", folder_format, "export")
    require_of("export", chosen)
    recorded = RecordedRun.open(run)
    write_folder(recorded, out, chosen)
    print_text(f"{counted(recorded.result.frames, 'frame is', 'frames are')} in {out}")


def mcap(
    run: RunFolder,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The .mcap file to write.")],
) -> None:
    """Write a run's recorded scans, ground truth and tracks as MCAP, for tools of ROS 2 and Foxglove."""
    require("mcap", "mcap")
    from luxloop.scenarios.offline.mcap.export import export
    from luxloop.scenarios.offline.recorded_scans import RecordedRun

    frames = export(RecordedRun.open(run), file)
    print_text(f"{frames} frames are in {file}")


def realism(
    data_sets: Annotated[
        list[Path], typer.Argument(metavar="DATASET...", help="Folders that luxloop run --dataset wrote.")
    ],
    real: Annotated[Path, typer.Option(metavar="TABLE.csv", help="Table of real vehicles, see docs/realism.md.")],
    real_bands: Annotated[
        Path | None, typer.Option(metavar="BANDS.csv", help="Table of the bow of real vehicles by height.")
    ] = None,
    label_sigma_deg: Annotated[
        float,
        typer.Option(
            min=0.0, max=10.0, callback=finite, help="Error added to the simulated headings, as real labels have."
        ),
    ] = 1.5,
    seed: Annotated[int, typer.Option(min=0, help="Seed of these errors.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Folder of the table, figures and matched vehicles.")] = None,
    as_json: AsJson = False,
) -> None:
    """Compare simulated vehicles with real ones, matched by range, aspect and end seen."""
    from luxloop.scenarios.document.document import json_text
    from luxloop.scenarios.realism import labelled_vehicle, real_table, realism_comparison, realism_table
    from luxloop.scenarios.report import text

    if out:
        realism_table.refuse_other_files(out)
    table, bands = real_table.read(real), real_table.read_bands(real_bands)
    vehicles = [
        vehicle
        for number, folder in enumerate(data_sets)
        for vehicle in labelled_vehicle.read(folder, number, label_sigma_deg, seed)
    ]
    comparison = realism_comparison.compare(table, bands, vehicles)
    if out:
        realism_table.write(comparison, out)
    shown = realism_table.document(comparison)
    if as_json:
        print_text(json_text(shown))
    else:
        text.show(shown)
        print_text(
            f"Figures and matched vehicles are in {out}" if out else "Nothing was written; for figures, give --out"
        )


def fits(
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER...", help="Labelled recordings, and folders that luxloop run --dataset wrote."),
    ],
    as_json: AsJson = False,
) -> None:
    """Grade the fits to labelled vehicles: each cut of a recording, and all data sets together, side by side."""
    from luxloop.scenarios.document.document import json_text
    from luxloop.scenarios.realism import fit_observations, fit_report
    from luxloop.scenarios.report import text

    shown = fit_report.document(fit_observations.of_folders(sources))
    if as_json:
        print_text(json_text(shown))
    else:
        text.show(shown)
