"""Type aliases of numpy arrays. Shapes, units and frames are documented where the aliases are used."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""float64 array."""
Ints = npt.NDArray[np.int64]
"""int64 array."""
Bools = npt.NDArray[np.bool_]
"""bool array."""
