"""Settings of the whole test session."""

import signal
import sys

import pytest

# Shells start background jobs with SIGINT ignored, which all their children inherit; tests press Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_configure(config: pytest.Config) -> None:
    """Skip assertion rewriting when tests are only listed: it takes half of the time, and no assertion runs."""
    hook = config.pluginmanager.rewrite_hook
    if config.option.collectonly and hook in sys.meta_path:
        sys.meta_path.remove(hook)
