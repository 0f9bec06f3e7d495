"""`luxloop warm-up`."""

from luxloop.scenarios.commands.arguments import Quiet, ScenarioName, Tracker

SCENARIO = "sumo-crossing"
"""Uses the kernels of traffic, sensor and tracker."""
SIMULATED_S = 0.8
"""Long enough for tracks."""


def warm_up(scenario: ScenarioName = SCENARIO, tracker: Tracker = None, quiet: Quiet = False) -> None:
    """Compile the numba kernels into their cache, so that parallel runs do not each compile them; writes no run."""
    import os
    import time

    # Before numba is imported: it colours an error for each type of argument that it tries, 7 % of the time.
    os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")

    from luxloop.scenarios.files import shipped
    from luxloop.scenarios.files.scenario import Scenario
    from luxloop.scenarios.run import device, loop
    from luxloop.scenarios.run.progress import hidden
    from luxloop.scenarios.run.tracker_warm_up import NoTracks, tracker_beside
    from luxloop.sensor_model.rig.rig import load_rig

    loaded = Scenario.load(shipped.find(scenario), {"duration_s": SIMULATED_S})
    make_device, began = device.load(tracker or device.SHIPPED), time.monotonic()
    with hidden(quiet):
        if tracker is None:
            with tracker_beside(loaded.tracker, load_rig(str(loaded.rig), loaded.folder)):
                loop.run(loaded, NoTracks)
        loop.run(loaded, make_device)
    if not quiet:
        print(f"The kernels are ready, after {time.monotonic() - began:.1f} s")
