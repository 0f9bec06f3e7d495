"""Rows of the graded vehicles of a run, and sums per row."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.arrays import Floats, Ints
from luxloop.sensor_model.truth import NO_ACTOR


class VehicleRows(NamedTuple):
    """Row of each vehicle; actors that were never graded share the row of `NO_ACTOR`, the first."""

    vehicle: Ints
    """(V,) ids, ascending."""

    @classmethod
    def of(cls, truth: pd.DataFrame) -> "VehicleRows":
        """Return the rows of the vehicles that the truth table calls graded in any frame."""
        return cls(np.union1d([NO_ACTOR], truth.loc[truth["graded"], "actor_id"]))

    def sum(self, actor_id: npt.ArrayLike, values: npt.ArrayLike | None = None) -> Floats:
        """(V,) sums of values (n,) of actors (n,), or numbers of rows without values."""
        actor_id = np.asarray(actor_id, dtype=np.int64)
        row = np.minimum(np.searchsorted(self.vehicle, actor_id), len(self.vehicle) - 1)
        row = np.where(self.vehicle[row] == actor_id, row, 0)
        weights = None if values is None else np.asarray(values, dtype=np.float64)
        return np.bincount(row, weights, len(self.vehicle)).astype(np.float64)
