"""Configuration of SUMO traffic."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from luxloop.sim.candidates.want import Want
from luxloop.sim.modes import ModeLimits
from luxloop.sim.physical.physical_config import PhysicalConfig
from luxloop.sim.source import TrafficSource
from luxloop.sim.sumo.options import SCENARIO_KEYS, full_name

OPENDRIVE = ".xodr"
"""Suffix of OpenDRIVE nets."""


@dataclass(frozen=True, slots=True)
class SumoTraffic:
    """SUMO traffic: a `.sumocfg`, or a net with routes. Paths are relative to the scenario file."""

    kind: Literal["sumo"] = "sumo"
    config: str = ""
    """A `.sumocfg`; omit `net`, `routes` and `additional` then."""
    net: str = ""
    """A `.net.xml`, or an OpenDRIVE file (`.xodr`), which netconvert of the extra `opendrive` converts at the start."""
    routes: list[str] = field(default_factory=list)
    """Route files: vehicle types, routes, flows, vehicles, persons."""
    additional: list[str] = field(default_factory=list)
    """Additional files. Shapes in them block beams: polygons of the types `building`, `wall`, `barrier`, `fence` or
    `guard_rail`, points of interest of the types `pole`, `street_lamp`, `tree`, `traffic_sign` or `bollard`, and any
    shape with a parameter `height` [m]. Further parameters: `base` and `diameter` [m], `reflectivity`."""
    ego: str = "first"
    """`vehicle:<id>`; `route:<id>`, the first vehicle that enters on it; `first`, the first vehicle that enters, or,
    with `min_vehicles`, the first that has as many around it; or `best`, the first in the list of `luxloop egos`, also
    `best:<want>` with `neighbours`, `turns`, `stops`, `occlusion` or `long`, by a survey of `max_wait_s`. `result.json`
    names the vehicle. Only vehicles are taken that can carry the rig: no trams, trains, bicycles, motorcycles."""
    ego_any_class: bool = False
    """Accept any vehicle as the ego, also a tram or a bicycle."""
    dt_s: float = 0.08
    """[s] SUMO's step, whole milliseconds, and the time between frames; the rig turns at 12.5 Hz."""
    begin_s: float | None = None
    """[s] Start of the simulation on SUMO's clock; vehicles with an earlier departure do not enter. Default: the begin
    of the configuration, else 0."""
    max_wait_s: float = 300.0
    """[s] Simulated time to wait for the ego, and for `min_vehicles` around it."""
    min_vehicles: int = 0
    """Frames begin when the ego is in the net with at least this number of other vehicles in sensor range."""
    frames_from_s: float | None = None
    """[s] Earliest frame 0 on SUMO's clock; before it the ego drives without frames. Default: none."""
    parking_fill: float = 0.0
    """Share of the places of parking areas that are occupied by parked cars, 0 to 1."""
    building_height_m: float = 10.0
    """[m] Default height of polygons without a parameter `height`."""
    redraw_default_sizes: bool = True
    """Replace vehicles and people of exactly SUMO's default size by random sizes of their class, drawn by the seed: no
    longer and no wider, with the same front bumper. Types with an explicit size, and the ego, keep theirs."""
    ego_control: bool = False
    """Let commands control the ego: it keeps the last commanded speed and lane regardless of red lights and other
    vehicles, and may collide with them; its accelerations stay within its type's limits. It keeps its lane from frame 0
    on; SUMO controls its speed until the first speed command. Needs `physical.lookahead_s = 0`."""
    physical: PhysicalConfig = field(default_factory=PhysicalConfig)
    """Physical truth layer, which converts SUMO's poses to feasible motions."""
    modes: ModeLimits = field(default_factory=ModeLimits)
    """Limits of the motion modes."""
    suspension: bool = True
    """If true, bodies pitch and roll by their accelerations, and riders lean into turns."""
    options: dict[str, str] = field(default_factory=dict)
    """Further SUMO options by long name, such as `lateral-resolution = "0.8"`, which makes lane changes gradual."""
    netconvert: dict[str, str] = field(default_factory=dict)
    """Further options of netconvert for an OpenDRIVE net, by long name, such as `"tls.cycle.time" = "70"`."""

    def __post_init__(self) -> None:
        if bool(self.config) == bool(self.net and self.routes):
            raise ValueError("set either config (a .sumocfg), or both net and routes")
        if self.config and self.additional:
            raise ValueError("additional requires net and routes; with config, list the files in the .sumocfg")
        selector, _, wanted = self.ego.partition(":")
        if selector == "best":
            if self.ego != "best" and wanted not in list(Want):
                raise ValueError(f'ego = "{self.ego}": write "best", or "best:" with one of {", ".join(Want)}')
        elif self.ego != "first" and not (selector in ("vehicle", "route") and wanted):
            raise ValueError(f'ego = "{self.ego}": write "vehicle:<id>", "route:<id>", "first" or "best"')
        if not (self.dt_s > 0 and self.max_wait_s > 0 and self.building_height_m > 0):
            raise ValueError("dt_s, max_wait_s and building_height_m must be positive")
        if round(self.dt_s, 3) != self.dt_s:
            raise ValueError(f"dt_s = {self.dt_s}: SUMO steps are whole milliseconds; use at most three decimals")
        clock = [time for time in (self.begin_s, self.frames_from_s) if time is not None]
        if self.min_vehicles < 0 or not all(time >= 0 for time in clock):
            raise ValueError("min_vehicles, begin_s and frames_from_s must not be negative")
        if not 0 <= self.parking_fill <= 1:
            raise ValueError(f"parking_fill = {self.parking_fill}: write a share from 0 to 1")
        if self.ego_control and self.physical.lookahead_s > 0:
            raise ValueError(
                "physical.lookahead_s must be 0 with ego_control = true: commands cannot reach a simulator ahead"
            )
        if self.netconvert and not self.net.endswith(OPENDRIVE):
            raise ValueError(f'netconvert requires an OpenDRIVE net ({OPENDRIVE}), not net = "{self.net}"')
        for option in self.options:
            if key := SCENARIO_KEYS.get(full_name(option)):
                raise ValueError(f"options.{option}: set the key {key} instead")

    def make_source(self, folder: Path, range_m: float) -> TrafficSource:
        """Make the source. See `luxloop.sim.factory.TrafficConfig`."""
        from luxloop.sim.sumo.sumo_source import SumoSource

        return SumoSource(self, folder, range_m)
