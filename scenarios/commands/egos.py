"""`luxloop egos`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import AsJson, Quiet, finite
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

    from luxloop.scenarios.authoring import candidate_table
    from luxloop.scenarios.authoring.ego_survey import survey_source
    from luxloop.scenarios.report import text
    from luxloop.scenarios.report.cells import counted
    from luxloop.scenarios.run.progress import hidden

    with hidden(quiet or as_json):
        survey = survey_source(source, routes or [], begin, window, seed)
    found, ranges = survey.candidates, (survey.sensor_range_m, survey.grading_range_m)
    rows = [int(row) for row in found.order(want, stay) if any_class or not found.bodies[row].rejected][:top]
    rejected = int((~found.suitable).sum())
    if as_json:
        entries = [candidate_table.document(found, row) for row in rows]
        head = {"source": source, "want": want.value, "left_out": survey.left_out, "vehicles": len(found)}
        print(json.dumps({**head, "candidates": entries}))
        return
    if rows:
        text.show(candidate_table.table(found, rows, want, ranges))
    more = f", {rejected} of which cannot carry the rig" if rejected else ""
    print("\n".join([f"{counted(len(found), 'vehicle')} entered{more}.", *survey.left_out]))
    if rows and not found.bodies[rows[0]].rejected:
        print(f'For a scenario: ego = "vehicle:{found.bodies[rows[0]].name}", or luxloop new {source} --out FILE.toml')
