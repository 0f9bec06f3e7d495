"""Uneven ground as the ray caster reads it."""

import math

import numpy as np

from sensor_model.arrays import Floats
from sensor_model.kernels.ground_hits import BLOCK
from sensor_model.kernels.records import Ground
from sim.world import Ego, Terrain

FLAT = Ground(np.empty((0, 0)), np.empty((0, 0)), np.zeros(7))
"""The plane z = 0."""


class UnevenGround:
    """Ground of one run around the moving ego.

    Parameters
    ----------
    terrain
        Height of the ground; None if it is flat.
    """

    def __init__(self, terrain: Terrain | None) -> None:
        self._terrain = terrain
        self._top = np.empty((0, 0)) if terrain is None else _block_tops(terrain.height)
        self._peak = -math.inf if terrain is None else float(terrain.height.max())

    def seen_from(self, ego: Ego) -> Ground:
        """Return the ground as seen from the level frame of the ego."""
        terrain = self._terrain
        if terrain is None:
            return FLAT
        (x, y), yaw = (ego.pose_world[:2] - terrain.corner_world) / terrain.cell, ego.pose_world[2]
        cos, sin = np.cos(yaw) / terrain.cell, np.sin(yaw) / terrain.cell
        return Ground(terrain.height, self._top, np.array([x, y, cos, sin, ego.ground_z, terrain.cell, self._peak]))


def _block_tops(height: Floats) -> Floats:
    """Return the highest node of each block of cells, the nodes on its border included."""
    blocks = [-(-(count - 1) // BLOCK) for count in height.shape]
    padded = np.pad(height, [(0, BLOCK * n + 1 - count) for n, count in zip(blocks, height.shape, strict=True)], "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (BLOCK + 1, BLOCK + 1))
    top: Floats = windows[::BLOCK, ::BLOCK].max(axis=(2, 3))
    return top
