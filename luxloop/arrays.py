"""Type aliases of numpy arrays. Each use documents shape, unit and frame."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""float64 array."""
Floats32 = npt.NDArray[np.float32]
"""float32 array."""
Ints = npt.NDArray[np.int64]
"""int64 array."""
Bools = npt.NDArray[np.bool_]
"""bool array."""
Bytes = npt.NDArray[np.uint8]
"""uint8 array."""
