"""Bands of the range: each distance is in one band, the upper end excluded."""

import numpy as np
import pandas as pd

from luxloop.scenarios.grading.bands import range_bands


def test_ends_of_bands_belong_to_the_next_one():
    rows = pd.DataFrame({"range_m": [0.0, 14.9, 15.0, 29.9, 30.0, 49.9, 50.0]})
    found = {name: np.flatnonzero(mask).tolist() for name, mask in range_bands(rows)}
    assert found == {".by_range.0_15": [0, 1], ".by_range.15_30": [2, 3], ".by_range.30_50": [4, 5]}
