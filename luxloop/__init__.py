"""Simulation-in-the-loop testbed for low-cost LIDAR vehicle tracking.

This module names the Python interface, which docs/command-line.md explains. A name is imported when it is used, so that
`import luxloop` is fast.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from luxloop import kernel_folder

if TYPE_CHECKING:
    from luxloop.errors import Error
    from luxloop.scenarios.compare.comparison import Comparison
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.interface import (
        ceiling,
        compare,
        grade,
        grade_boxes,
        list_scenarios,
        load_result,
        load_scenario,
        run,
    )
    from luxloop.scenarios.result import Metric, Result
    from luxloop.tracker.records import Tracks
    from luxloop.tracker.scan import Scan
    from luxloop.tracker.tracker import Tracker, TrackerConfig

    __version__: str

__all__ = [
    "Comparison",
    "Error",
    "Metric",
    "Result",
    "Scan",
    "Scenario",
    "Tracker",
    "TrackerConfig",
    "Tracks",
    "__version__",
    "ceiling",
    "compare",
    "grade",
    "grade_boxes",
    "list_scenarios",
    "load_result",
    "load_scenario",
    "run",
]

kernel_folder.use_shipped(Path(__file__).parent)
kernel_folder.choose(Path(__file__).parent)

_MODULES = {
    "Comparison": "luxloop.scenarios.compare.comparison",
    "Error": "luxloop.errors",
    "Metric": "luxloop.scenarios.result",
    "Result": "luxloop.scenarios.result",
    "Scan": "luxloop.tracker.scan",
    "Scenario": "luxloop.scenarios.files.scenario",
    "Tracker": "luxloop.tracker.tracker",
    "TrackerConfig": "luxloop.tracker.tracker",
    "Tracks": "luxloop.tracker.records",
    "ceiling": "luxloop.scenarios.interface",
    "compare": "luxloop.scenarios.interface",
    "grade": "luxloop.scenarios.interface",
    "grade_boxes": "luxloop.scenarios.interface",
    "list_scenarios": "luxloop.scenarios.interface",
    "load_result": "luxloop.scenarios.interface",
    "load_scenario": "luxloop.scenarios.interface",
    "run": "luxloop.scenarios.interface",
}
"""Modules of the names."""


if not TYPE_CHECKING:  # a type checker would accept every name

    def __getattr__(name: str) -> object:
        """Import a name of the interface on its first use."""
        if name == "__version__":
            from importlib.metadata import version

            value = version("luxloop")
        elif name in _MODULES:
            value = getattr(import_module(_MODULES[name]), name)
        else:
            raise AttributeError(f"module 'luxloop' has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
