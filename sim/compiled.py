"""Decorator of the package's kernels."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


def kernel(**options: Any) -> Callable[[FunctionT], FunctionT]:
    """Return a decorator that compiles a function by `numba.njit` and caches the result beside the source file.

    `options` are those of `numba.njit`. A wrapper for calls from C is left out: it takes a sixth of the compilation.
    """
    settings: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True, **options}
    decorator: Callable[[FunctionT], FunctionT] = njit(**settings)
    return decorator
