"""Weeks of remission of 42 leukaemia patients (Freireich et al. 1963, Blood 21, 699; as in Gehan 1965)."""

import numpy as np

TREATED = np.array([6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35], dtype=float)
"""With 6-mercaptopurine."""
REACHED = np.isin(np.arange(21), [0, 1, 2, 4, 6, 9, 10, 14, 15])
"""Those of the treated whose remission ended; the others are censored."""
PLACEBO = np.array([1, 1, 2, 2, 3, 4, 4, 5, 5, 8, 8, 8, 8, 11, 11, 12, 12, 15, 17, 22, 23], dtype=float)
