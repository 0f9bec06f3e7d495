"""Type aliases of numpy arrays. Shapes, units and frames stand where they are used."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""float64 array."""
Ints = npt.NDArray[np.int64]
"""int64 array."""
Bools = npt.NDArray[np.bool_]
"""bool array."""
Floats32 = npt.NDArray[np.float32]
"""float32 array."""
