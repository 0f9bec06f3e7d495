"""Cases of parametrized tests of which `make test` runs a few, and `make slow` the others."""

from collections.abc import Iterable
from typing import Any

import pytest


def few(cases: Iterable[Any], *quick: Any) -> list[Any]:
    """Return the cases of a test, with the mark `slow` on all but those that are, or begin with, one of `quick`."""
    params, missing = [], set(quick)
    for case in cases:
        values = case if isinstance(case, tuple) else (case,)
        missing.discard(values[0])
        params.append(pytest.param(*values, marks=[] if values[0] in quick else pytest.mark.slow))
    assert not missing, f"no cases: {missing}"
    return params
