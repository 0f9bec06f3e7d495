"""`luxloop new`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import AsJson, Quiet, finite
from luxloop.scenarios.commands.egos import Begin, Routes, Window
from luxloop.sim.candidates.want import Want


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

    from luxloop.scenarios.authoring.draft_options import DraftOptions
    from luxloop.scenarios.authoring.new_scenario import write_scenario
    from luxloop.scenarios.run.progress import hidden

    options = DraftOptions(out, duration, seed, want, ego, begin, window)
    with hidden(quiet or as_json):
        choices = write_scenario(source, routes or [], options, force=force)
    if as_json:
        print(json.dumps({"out": str(out), "choices": choices}))
    elif not quiet:
        print("\n".join(choices))
        print(f"Its limits are generic defaults: adapt them. To run it: luxloop run {out}")
