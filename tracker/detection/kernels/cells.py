"""Kernel of the memory of cells."""

import numpy as np
from numba import njit

from tracker.arrays import Bools, Ints


@njit(cache=True)
def contained(cells: Ints, known: Ints) -> Bools:
    """(N,) mask of the cells that are among the sorted `known` ones; a search serves all equal cells that follow."""
    found = np.zeros(len(cells), np.bool_)
    for i in range(len(cells)):
        if i > 0 and cells[i] == cells[i - 1]:
            found[i] = found[i - 1]
        else:
            place = np.searchsorted(known, cells[i])
            found[i] = place < len(known) and known[place] == cells[i]
    return found
