"""`luxloop realism`."""

from pathlib import Path
from typing import Annotated

import typer

from luxloop.scenarios.commands.arguments import AsJson, finite


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
    import json

    from luxloop.scenarios.realism import data_set_reader, real_table, realism_comparison, realism_folder, realism_table
    from luxloop.scenarios.report import text

    if out:
        realism_folder.refuse_other_files(out)
    table, bands = real_table.read(real), real_table.read_bands(real_bands)
    vehicles = [
        vehicle
        for number, folder in enumerate(data_sets)
        for vehicle in data_set_reader.read(folder, number, label_sigma_deg, seed)
    ]
    comparison = realism_comparison.compare(table, bands, vehicles)
    if out:
        realism_folder.write(comparison, out)
    if as_json:
        print(json.dumps(realism_table.document(comparison), allow_nan=False))
    else:
        text.show(realism_table.report(comparison))
        print(f"Figures and matched vehicles are in {out}" if out else "Nothing was written; for figures, give --out")
