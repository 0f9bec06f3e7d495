"""The functions of `elementary` for arrays, and products of matrices: the same bits on every processor."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.compiled import kernel


def sin(angle: npt.ArrayLike) -> Floats:
    """Return the sines of angles [rad]."""
    return _replaced(_sin, angle)


def cos(angle: npt.ArrayLike) -> Floats:
    """Return the cosines of angles [rad]."""
    return _replaced(_cos, angle)


def tan(angle: npt.ArrayLike) -> Floats:
    """Return the tangents of angles [rad]."""
    return _replaced(_tan, angle)


def atan2(y: npt.ArrayLike, x: npt.ArrayLike) -> Floats:
    """Return the angles of points [rad], which broadcast."""
    across, along = np.broadcast_arrays(np.asarray(y, np.float64), np.asarray(x, np.float64))
    angle = np.array(across)
    _atan2(angle.reshape(-1), np.array(along).reshape(-1))
    return _number_or_array(angle)


def hypot(x: npt.ArrayLike, y: npt.ArrayLike) -> Floats:
    """Return the lengths of vectors, which broadcast."""
    along, across = np.asarray(x, np.float64), np.asarray(y, np.float64)
    return np.sqrt(along * along + across * across)


def exp(x: npt.ArrayLike) -> Floats:
    """Return e to the power of numbers."""
    return _replaced(_exp, x)


def log(x: npt.ArrayLike) -> Floats:
    """Return natural logarithms."""
    return _replaced(_log, x)


def log1p(x: npt.ArrayLike) -> Floats:
    """Return the natural logarithms of 1 plus numbers."""
    return _replaced(_log1p, x)


def log10(x: npt.ArrayLike) -> Floats:
    """Return logarithms to the base 10."""
    return _replaced(_log10, x)


def product(one: npt.ArrayLike, other: npt.ArrayLike) -> Floats:
    """Return the product of matrices (..., I, J) and (..., J, K), or vectors, as `numpy.matmul`.

    The terms are added in the order of J. Libraries of linear algebra choose the order by the processor.
    """
    left, right = np.asarray(one, np.float64), np.asarray(other, np.float64)
    if left.ndim == 1:
        return product(left[None], right)[..., 0, :] if right.ndim > 1 else product(left[None], right[:, None])[0, 0]
    if right.ndim == 1:
        return product(left, right[:, None])[..., 0]
    leading = np.broadcast_shapes(left.shape[:-2], right.shape[:-2])
    total: Floats = np.zeros((*leading, left.shape[-2], right.shape[-1]))
    for j in range(left.shape[-1]):
        total += left[..., :, j : j + 1] * right[..., j : j + 1, :]
    return total


def inverse(matrix: npt.NDArray[Any]) -> Floats:
    """Return the inverses of positive definite matrices (..., N, N), by Gauss-Jordan elimination without exchanges."""
    size = matrix.shape[-1]
    rows = np.concatenate([matrix, np.broadcast_to(np.eye(size), matrix.shape)], axis=-1)
    for i in range(size):
        rows[..., i, :] /= rows[..., i, i, None]
        for j in range(size):
            if j != i:
                rows[..., j, :] -= rows[..., j, i, None] * rows[..., i, :]
    return np.asarray(rows[..., size:])


def _replaced(function: Callable[[Floats], None], argument: npt.ArrayLike) -> Floats:
    """Return a copy of an array, with its numbers replaced by a function."""
    value = np.array(argument, np.float64, order="C")
    function(value.reshape(-1))
    return _number_or_array(value)


def _number_or_array(value: Floats) -> Floats:
    return value if value.ndim else value[()]


@kernel()
def _sin(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.sin(x[i])


@kernel()
def _cos(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.cos(x[i])


@kernel()
def _tan(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.tan(x[i])


@kernel()
def _exp(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.exp(x[i])


@kernel()
def _log(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.log(x[i])


@kernel()
def _log1p(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.log1p(x[i])


@kernel()
def _log10(x: Floats) -> None:
    for i in range(x.shape[0]):
        x[i] = elementary.log10(x[i])


@kernel()
def _atan2(y: Floats, x: Floats) -> None:
    for i in range(y.shape[0]):
        y[i] = elementary.atan2(y[i], x[i])
