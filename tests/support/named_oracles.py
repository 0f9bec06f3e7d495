"""Oracles that sweeps of tests name, which no user can; workers import this module."""

from collections.abc import Iterator

import pytest
from support import crossing_ids, short_memory

SPECS = (crossing_ids.SPEC, short_memory.SPEC)


@pytest.fixture(scope="session", autouse=True)
def known_to_workers() -> Iterator[None]:
    """Let workers of sweeps know the oracles."""
    config = pytest.importorskip("dask.config")
    with config.set({"distributed.worker.preload": [__name__]}):
        yield
