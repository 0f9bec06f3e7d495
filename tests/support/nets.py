"""Traffic on the test nets in tests/nets."""

from support.paths import NETS

from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.sumo_source import SumoSource

TRAFFIC = {
    # without further options, lane changes take one step
    "grid": {"net": "grid/grid.net.xml.gz", "options": {"lateral-resolution": "0.8"}},
    "spider": {"options": {"time-to-teleport": "12"}},
    "roundabout": {},
    "winding": {"options": {"lanechange.duration": "3"}},
    "motorway": {},
    "left-hand": {"options": {"lateral-resolution": "0.8"}},
    "far-off": {"additional": ["far-off/far-off.add.xml"]},
    "spreewaldring": {"config": "spreewaldring/spreewaldring.sumocfg"},
}
"""Keys of `SumoTraffic` by the name of the net."""


def source_on(name, range_m=60.0, **keys):
    """Return a source of traffic on a test net."""
    defaults = (
        {}
        if "config" in TRAFFIC[name]
        else {
            "net": f"{name}/{name}.net.xml",
            "routes": ["mixed.rou.xml", f"{name}/{name}.rou.xml"],
        }
    )
    return SumoSource(SumoTraffic(ego="vehicle:ego", **defaults | TRAFFIC[name] | keys), NETS, range_m)
