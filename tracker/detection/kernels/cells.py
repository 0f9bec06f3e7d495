"""Kernel of the memory of cells."""

import numpy as np

from luxloop.tracker.arrays import Bools, Ints
from luxloop.tracker.compiled import kernel


@kernel()
def contained(cells: Ints, known: Ints) -> Bools:
    """(N,) mask of the cells that are among the sorted `known` ones; a search serves all equal cells that follow."""
    found = np.zeros(len(cells), np.bool_)
    for i in range(len(cells)):
        if i > 0 and cells[i] == cells[i - 1]:
            found[i] = found[i - 1]
        else:
            place, end = 0, len(known)  # bisection: numpy's takes half a second to compile
            while place < end:
                middle = (place + end) // 2
                if known[middle] < cells[i]:
                    place = middle + 1
                else:
                    end = middle
            found[i] = place < len(known) and known[place] == cells[i]
    return found
