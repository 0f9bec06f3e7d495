"""Survey of SUMO traffic without an ego: all vehicles, at regular moments.

Seed and step are those of a run, so that the vehicles are the same.
"""

from pathlib import Path
from typing import Any

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats
from luxloop.sim.candidates.candidates import Body, Moment
from luxloop.sim.source import (
    EgoCommand,
    SimulatorFailedError,
    StartReport,
    TrafficEndedError,
    TrafficInputError,
    ignore_status,
)
from luxloop.sim.sumo.session import SumoSession
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.vehicles import OFF_ROAD_M, is_rejected, kind_of_shape, yaw_of
from luxloop.sim.world import VEHICLE_KINDS

INTERVAL_S = 1.0
"""[s] Time between two moments, rounded to whole steps."""


class SumoSurvey:
    """Survey of a SUMO simulation, with the interface of a traffic source, so that it can run in its own process.

    Vehicles are read one by one and only at the moments: a subscription would cost in every step of SUMO.

    Parameters
    ----------
    config
        Traffic to simulate; `ego` is ignored.
    folder
        Folder of the scenario file.
    """

    def __init__(self, config: SumoTraffic, folder: Path):
        self._steps = max(1, round(INTERVAL_S / config.dt_s))
        self.dt = self._steps * config.dt_s
        self.origin: Floats = np.zeros(2)
        self.warnings: tuple[str, ...] = ()
        self.ego_name = ""
        self.report_start: StartReport = ignore_status
        self._session = SumoSession(config, folder)
        self._sumo: Any = None

    def reset(self, seed: int) -> None:
        """Start SUMO. See `TrafficSource.reset`."""
        self._sumo = self._session.start(seed, self.report_start)
        self._known: dict[str, tuple[int, float]] = {}
        self._begin = self._sumo.simulation.getTime()

    def step(self) -> Moment:
        """Advance to the next moment and return it.

        Raises
        ------
        TrafficEndedError
            No road user is left, and none will enter.
        TrafficInputError
            SUMO rejects its input when it gets there, such as a lane that does not exist.
        """
        sumo = self._sumo
        if sumo is None:
            raise SimulatorFailedError("SUMO is not running: call reset before step")
        now = sumo.simulation.getTime()
        if now > self._begin and sumo.simulation.getMinExpectedNumber() == 0:
            raise TrafficEndedError(f"the traffic ends at {now:.0f} s")
        try:
            for _ in range(self._steps):
                sumo.simulationStep()
            return self._moment()
        except (sumo.TraCIException, sumo.FatalTraCIError) as error:
            raise self._session.input_error(str(error)) from error

    def apply(self, command: EgoCommand) -> None:
        """Reject the command: there is no ego."""
        raise TrafficInputError(f"a survey has no ego and accepts no {command}")

    def close(self) -> None:
        """End the simulation if it is running."""
        self._session.close()
        self._sumo = None

    def _moment(self) -> Moment:
        vehicle = self._sumo.vehicle
        new, rows = [], []
        for name in sorted(vehicle.getIDList()):
            x, y = vehicle.getPosition(name)
            if x < OFF_ROAD_M:
                continue
            if name not in self._known:
                body = self._body(name)
                self._known[name] = len(self._known), body.size[0]
                new.append(body)
            number, length = self._known[name]
            rows.append((number, x, y, yaw_of(vehicle.getAngle(name)), vehicle.getSpeed(name), length))
        table = np.array(rows, dtype=np.float64).reshape(-1, 6)
        yaw = table[:, 3]
        centre = table[:, 1:3] - 0.5 * table[:, 5:] * np.column_stack([elementwise.cos(yaw), elementwise.sin(yaw)])
        return Moment(
            time=float(self._sumo.simulation.getTime()),
            new=new,
            body=table[:, 0].astype(np.int64),
            pose=np.column_stack([centre, yaw]),
            speed=np.abs(table[:, 4]),
        )

    def _body(self, name: str) -> Body:
        vehicle = self._sumo.vehicle
        return Body(
            name=name,
            vehicle_class=vehicle.getVehicleClass(name),
            size=(vehicle.getLength(name), vehicle.getWidth(name)),
            graded=kind_of_shape(vehicle.getShapeClass(name), vehicle.getHeight(name)) in VEHICLE_KINDS,
            rejected=is_rejected(vehicle, name),
        )
