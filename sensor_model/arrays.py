"""Type aliases of numpy arrays. Shapes, units and frames are documented at each use."""

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""float64 array."""
Ints = npt.NDArray[np.int64]
"""int64 array."""
Bools = npt.NDArray[np.bool_]
"""bool array."""
Bytes = npt.NDArray[np.uint8]
"""uint8 array."""
Key = npt.NDArray[np.uint32]
"""(2,) uint32 key of a Philox generator."""
