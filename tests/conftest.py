"""Settings of the whole test session."""

import gc
import os
import signal
import sys
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from hypothesis import is_hypothesis_test, settings
from support.real_data import VARIABLE

from luxloop.sim.rare_collection import YOUNG

# Shells start background jobs with SIGINT ignored, nohup with SIGHUP; all children inherit that, and tests send both.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# The same examples in each run, at any speed of the machine. To search for others: --hypothesis-profile=default.
# `make slow` runs the properties again, with more examples.
settings.register_profile("fixed", derandomize=True, deadline=None, max_examples=10)
settings.register_profile("more", parent=settings.get_profile("fixed"), max_examples=100)
settings.load_profile("fixed")
SLOW_ONLY = "slow"
"""The expression of `-m` in `make slow`."""


@pytest.fixture(autouse=True)
def _sys_path_is_restored() -> Iterator[None]:
    """Trackers that run in this process leave their folders on the path, where later tests would find their modules."""
    before = [*sys.path]
    yield
    sys.path[:] = before


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--real-data", metavar="DIR", help=f"folder of real recordings, in place of {VARIABLE}")


def pytest_configure(config: pytest.Config) -> None:
    """Pass on the folder of real recordings, also to processes that tests start.

    Skip assertion rewriting when tests are only listed: it takes half of the time, and no assertion runs.
    """
    if config.option.markexpr == SLOW_ONLY and not config.getoption("--hypothesis-profile"):
        settings.load_profile("more")
    if folder := config.getoption("--real-data"):
        os.environ[VARIABLE] = str(Path(folder).absolute())
    hook = config.pluginmanager.rewrite_hook
    if config.option.collectonly and hook in sys.meta_path:
        sys.meta_path.remove(hook)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage while tests are collected, and leave their half a million objects out of later collections.

    They live until the end; searching them for garbage takes 8 % of the time of the tests. Later collections are as
    rare as in luxloop's own processes: Hypothesis makes each slower.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(YOUNG)
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Add the properties to the slow tests."""
    if config.option.markexpr == SLOW_ONLY:
        for item in items:
            if is_hypothesis_test(getattr(item, "obj", None)):
                item.add_marker("slow")
