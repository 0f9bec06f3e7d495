"""Printed report of `luxloop ceiling`: HOTA beside what the scans allow, a row per run."""

from collections.abc import Sequence
from dataclasses import asdict

from luxloop.scenarios.document.document import Answer, Document, Paragraph, Section
from luxloop.scenarios.oracle.ceiling import Ceiling, mean
from luxloop.scenarios.oracle.ceiling_tracker import PoseNoise
from luxloop.scenarios.report.cells import NONE, table_of

COLUMNS = {
    "hota": "HOTA",
    "exact": "ceiling, exact",
    "noisy": "ceiling, noisy",
    "lost_by_scans": "lost by scans",
    "lost_by_noise": "by noise",
    "lost_by_tracker": "by tracker",
}
"""Titles of the values of a `Ceiling`."""


def ceiling_document(ceilings: Sequence[Ceiling], noise: PoseNoise) -> Document:
    """Return the report of runs of one scenario."""
    name = ceilings[0].scenario
    table = table_of("HOTA and its ceiling", "seed", *COLUMNS.values())
    for one in ceilings:
        table.add_row(str(one.seed), *(_cell(getattr(one, value)) for value in COLUMNS))
    means = {value: mean(ceilings, value) for value in COLUMNS}
    if len(ceilings) > 1:
        table.add_row("mean", *map(_cell, means.values()), style="bold")
    errors = f"Ceiling, noisy: errors of {noise.heading_deg:g} degrees and {noise.position_m:g} m in every frame."
    early = [
        f"Seed {one.seed} ended after {one.frames} frames: {one.ended_early}" for one in ceilings if one.ended_early
    ]
    hota, exact, noisy = (_cell(means[value]) for value in ("hota", "exact", "noisy"))
    return Document(
        f"{name}: the ceiling of HOTA",
        Answer(f"HOTA is {hota}; the scans allow {exact}, and {noisy} with errors of the poses"),
        [],
        [Section("ceiling", "Ceiling", [table, *(Paragraph(line, "dim") for line in [errors, *early])])],
        data={"scenario": name, "noise": asdict(noise), "runs": [one.data for one in ceilings], "mean": means},
    )


def _cell(value: float | None) -> str:
    return NONE if value is None else f"{value:.3f}"
