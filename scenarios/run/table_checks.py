"""Checks of the tables of a run that is read from disk: a damaged one would fail far from its cause."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.frame_tables import SCHEMAS

LARGEST = 1e12
"""Absolute value of any finite number, in any unit."""
FINITE = ("truth",)
"""Tables without infinite numbers."""
KINDS = {np.int64: "iu", np.float64: "fiu", np.bool_: "b"}
"""Kinds of dtype by the type of a column."""


def require_table(name: str, table: pd.DataFrame) -> None:
    """Check types and magnitudes of the columns of a table.

    Raises
    ------
    ValueError
        A column has another type, or a number that no run has.
    """
    schema = SCHEMAS.get(name, {})
    if not table.columns.is_unique:
        raise ValueError(f"a column of {name} occurs twice")
    for column in map(str, table.columns):
        cells, wanted = table[column], schema.get(column)
        plain = pd.api.types.is_numeric_dtype(cells) or isinstance(cells.dtype, pd.CategoricalDtype)
        if not (plain or pd.api.types.is_string_dtype(cells)):
            raise ValueError(f"column {column} of {name} holds {cells.dtype}")
        if isinstance(wanted, type) and wanted in KINDS and getattr(cells.dtype, "kind", "O") not in KINDS[wanted]:
            raise ValueError(f"column {column} of {name} holds {cells.dtype}, not {wanted.__name__}")
        if cells.dtype.kind in "fiu":
            _require_magnitude(name, column, cells.to_numpy(np.float64))


def _require_magnitude(name: str, column: str, values: np.ndarray) -> None:
    wrong = np.abs(values) > LARGEST
    if name not in FINITE:
        wrong &= np.isfinite(values)
    if wrong.any():
        raise ValueError(f"column {column} of {name}: {values[np.argmax(wrong)]:g} is no plausible number")
