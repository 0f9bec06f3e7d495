"""Checks of `summary.json` of a recording."""

import math
from typing import Any

import numpy as np

LARGEST_M = 1e3
"""Absolute value of the coordinates of a mount."""


def require_summary(summary: Any) -> None:
    """Check the content of `summary.json`.

    Raises
    ------
    ValueError, TypeError, LookupError
        A key is missing, or has a value of a wrong type, or a number is not finite.
    """
    _require_finite(summary)
    if not (isinstance(summary["files"], list) and all(isinstance(name, str) for name in summary["files"])):
        raise ValueError("summary.json: files should be a list of names")
    if not isinstance(summary["duration_s"], int | float) or not isinstance(summary["frames"], int):
        raise ValueError("summary.json: duration_s and frames should be numbers")
    for mount in summary["mounts"]:
        origin = np.array(mount["origin_ego_m"], dtype=np.float64)
        if origin.shape != (3,) or not np.all(np.abs(origin) <= LARGEST_M):
            raise ValueError("summary.json: origin_ego_m of a mount should be three numbers")


def _require_finite(value: Any) -> None:
    if isinstance(value, dict | list):
        for child in value.values() if isinstance(value, dict) else value:
            _require_finite(child)
    elif isinstance(value, int | float) and not (abs(value) < 1e300 and math.isfinite(value)):
        raise ValueError("summary.json: a number is not finite")
