"""Figures of many seeds as populations, from committed CSV files; `collect` makes these from the rows of sweeps."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import pandas as pd

Kind = Literal["median", "share", "seeds with any", "difference"]

FOLDER = Path(__file__).parents[1] / "seed_figures"
DIGITS = 4
"""Significant digits in the CSV files."""

HEADING, POSITION = "fit.heading_abs_mean_deg", "fit.position_abs_mean_m"
COLUMNS = {
    "standing": ("range_m", HEADING, POSITION, "track.missed", "track.false", "track.hota"),
    "hidden": ("track.occlusion_survival", "track.id_switches", "track.missed", "track.false", "track.hota"),
}
"""Columns of each sweep beside the seed."""


class Shown(NamedTuple):
    """A row of the table: a metric at one setting."""

    sweep: str
    metric: str
    range_m: float | None
    kinds: tuple[Kind, ...]


class Population(NamedTuple):
    """Figures of all seeds at one setting."""

    name: str
    rows: pd.DataFrame
    """`seed` and `value`; NaN for a seed without a value."""
    kinds: tuple[Kind, ...]


SHOWN = (
    *(Shown("standing", name, at, ("median",)) for name in (HEADING, POSITION, "track.hota") for at in (15.0, 32.0)),
    *(
        Shown("standing", name, None, ("difference",))
        for name in (HEADING, POSITION, "track.hota", "track.missed", "track.false")
    ),
    Shown("standing", "track.missed", 32.0, ("median",)),
    Shown("standing", "track.false", 32.0, ("median", "seeds with any")),
    Shown("hidden", "track.occlusion_survival", None, ("share",)),
    Shown("hidden", "track.id_switches", None, ("median", "seeds with any")),
    Shown("hidden", "track.missed", None, ("median",)),
    Shown("hidden", "track.false", None, ("median", "seeds with any")),
    Shown("hidden", "track.hota", None, ("median",)),
)


def populations(shown: tuple[Shown, ...]) -> Iterator[Population]:
    """Yield the population of each row; without a range, the standing car at 32 m minus that at 15 m."""
    tables = {sweep: pd.read_csv(FOLDER / f"{sweep}.csv") for sweep in COLUMNS}
    for one in shown:
        table = tables[one.sweep]
        if one.sweep == "hidden":
            yield Population(f"`{one.metric}`, hidden car", _values(table, one.metric), one.kinds)
        elif one.range_m is not None:
            at = table[table["range_m"] == one.range_m]
            yield Population(f"`{one.metric}`, {one.range_m:g} m", _values(at, one.metric), one.kinds)
        else:
            near, far = (table[table["range_m"] == at].set_index("seed")[one.metric] for at in (15.0, 32.0))
            rows = (far - near).rename("value").reset_index()
            yield Population(f"`{one.metric}`, 32 m minus 15 m", rows, one.kinds)


def _values(table: pd.DataFrame, metric: str) -> pd.DataFrame:
    return table[["seed", metric]].rename(columns={metric: "value"})


def collect(sweeps: Path) -> None:
    """Write the CSV files from the folders `standing` and `hidden` of sweeps."""
    for sweep, columns in COLUMNS.items():
        rows = pd.read_parquet(sweeps / sweep / "runs.parquet")
        rows[["seed", *columns]].to_csv(FOLDER / f"{sweep}.csv", index=False, float_format=f"%.{DIGITS}g")
