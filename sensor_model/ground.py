"""Uneven ground as the ray caster reads it."""

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.sensor_model.kernels.ground_hits import BLOCK
from luxloop.sensor_model.kernels.records import Ground
from luxloop.sim.world import Ego, Terrain

FLAT = Ground(np.empty((0, 0)), np.empty((0, 0, 3)), np.zeros(7))
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
        if terrain is not None:
            self._height = _framed(terrain.height)
            self._lid, self._peak = _lids(self._height), float(terrain.height.max())

    def seen_from(self, ego: Ego) -> Ground:
        """Return the ground as seen from the level frame of the ego."""
        terrain = self._terrain
        if terrain is None:
            return FLAT
        x, y = (ego.pose_world[:2] - terrain.corner_world) / terrain.cell + BLOCK
        cos, sin = elementary.cos(ego.pose_world[2]) / terrain.cell, elementary.sin(ego.pose_world[2]) / terrain.cell
        return Ground(self._height, self._lid, np.array([x, y, cos, sin, ego.ground_z, terrain.cell, self._peak]))


def _framed(height: Floats) -> Floats:
    """Return whole blocks of cells, with a frame of level blocks that continue the border outwards."""
    return np.pad(height, [(BLOCK, BLOCK + -(count - 1) % BLOCK) for count in height.shape], "edge")


def _lids(height: Floats) -> Floats:
    """Return the (BX, BY, 3) lids of whole blocks, see `records.Ground`.

    A lid has the mean slope between opposite sides of its block. The lids of the frame are level outwards, so that they
    hold beyond it.
    """
    nodes = np.lib.stride_tricks.sliding_window_view(height, (BLOCK + 1, BLOCK + 1))[::BLOCK, ::BLOCK]
    tilt_x = (nodes[:, :, -1, :] - nodes[:, :, 0, :]).mean(axis=-1) / BLOCK
    tilt_y = (nodes[:, :, :, -1] - nodes[:, :, :, 0]).mean(axis=-1) / BLOCK
    step = np.arange(BLOCK + 1)
    over = nodes - tilt_x[:, :, None, None] * step[:, None] - tilt_y[:, :, None, None] * step
    column, row = np.ogrid[: len(nodes), : nodes.shape[1]]
    at_origin = over.max(axis=(2, 3)) - BLOCK * (column * tilt_x + row * tilt_y)
    return np.stack([tilt_x, tilt_y, at_origin], axis=-1)
