"""Statistical test of independence."""

import numpy as np
from scipy.stats import chi2_contingency, rankdata

BINS = 6


def dependence(one, other):
    """Return the p-value of independence of two series (N,), by their joint histogram of ranks (Pearson 1900)."""
    ranks = [((rankdata(series) - 0.5) / len(series) * BINS).astype(int) for series in (one, other)]
    table = np.zeros((BINS, BINS))
    np.add.at(table, tuple(ranks), 1)
    return chi2_contingency(table).pvalue
