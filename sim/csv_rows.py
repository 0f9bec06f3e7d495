"""Rows of CSV files with more cells than the header, which pandas would read shifted."""

from typing import Any


def surplus(table: Any) -> str | None:
    """Return the fault and its remedy if the first row has more cells than the header; None if it has not.

    pandas takes the first columns of such a file for the index, which shifts all others, and `index_col=False` would
    drop the last cells. Longer rows further down are errors of pandas itself.

    Parameters
    ----------
    table
        Table as `pandas.read_csv` returns it without an argument on the index.
    """
    import pandas as pd

    if isinstance(table.index, pd.RangeIndex):
        return None
    header = len(table.columns)
    return (
        f"row 1: {table.index.nlevels + header} cells, but the header has {header}; "
        "give each row as many cells as the header, without a comma at the end"
    )
