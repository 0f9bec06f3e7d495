"""Choice of the ego in SUMO."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from luxloop.sim.candidates.candidate_log import CandidateLog
from luxloop.sim.candidates.want import Want
from luxloop.sim.source import StartReport, StartStatus, TrafficEndedError, TrafficInputError, ignore_status
from luxloop.sim.sumo.sumo_config import SumoTraffic
from luxloop.sim.sumo.survey import SumoSurvey
from luxloop.sim.sumo.vehicles import OFF_ROAD_M, is_rejected

LISTED = 8
"""Largest number of names in a message."""
CHECK_S = 1.0
"""[s] Time between two checks of the surroundings of all vehicles."""


@dataclass(slots=True)
class Entries:
    """Vehicles that have entered, by their ids or the ids of their routes."""

    suitable: dict[str, None] = field(default_factory=dict)
    rejected: dict[str, str] = field(default_factory=dict)
    """With the vehicle class."""


def best_ego(config: SumoTraffic, folder: Path, seed: int, range_m: float, report: StartReport = ignore_status) -> str:
    """Return the SUMO id of the first candidate in the order of `Candidates.order`, by a survey of `max_wait_s`.

    Raises
    ------
    TrafficInputError
        No vehicle entered that can carry the rig, or the input is invalid.
    """
    want = Want(config.ego.partition(":")[2] or Want.NEIGHBOURS)
    log, survey = CandidateLog(range_m), SumoSurvey(config, folder)
    survey.report_start = report
    try:
        survey.reset(seed)
        for moment in range(count := max(1, round(config.max_wait_s / survey.dt))):
            report(StartStatus(f"SUMO runs for the choice of the ego, {config.max_wait_s:.0f} s", moment / count))
            log.add(survey.step())
    except TrafficEndedError:
        pass
    finally:
        survey.close()
    found = log.candidates()
    rows = [row for row in found.order(want) if config.ego_any_class or not found.bodies[row].rejected]
    if not rows:
        raise TrafficInputError(
            none_entered(config.ego, config.max_wait_s, [body.vehicle_class for body in found.bodies])
        )
    name: str = found.bodies[rows[0]].name
    return name


def await_ego(
    sumo: Any, ego: str, until: float, report: StartReport = ignore_status, *, any_class: bool = False
) -> str:
    """Step SUMO until the ego enters.

    Parameters
    ----------
    sumo
        The libsumo module, running.
    ego
        Selector of the ego, see `luxloop.sim.sumo.sumo_config.SumoTraffic`.
    until
        Time limit on SUMO's clock [s].
    report
        Called with the progress.
    any_class
        Accept vehicles that cannot carry the rig.

    Returns
    -------
    name
        The ego's SUMO id.

    Raises
    ------
    TrafficInputError
        The ego did not enter, or cannot carry the rig.
    """
    selector, _, wanted = ego.partition(":")
    entries, begin = Entries(), sumo.simulation.getTime()
    while _goes_on(sumo, begin, until, report):
        sumo.simulationStep()
        for name in sorted(sumo.simulation.getDepartedIDList()):
            label = sumo.vehicle.getRouteID(name) if selector == "route" else name
            chosen = selector == "first" or label == wanted
            if any_class or not is_rejected(sumo.vehicle, name):
                if chosen:
                    return str(name)
                entries.suitable[label] = None
            elif chosen and selector == "vehicle":
                raise TrafficInputError(
                    f'ego = "{ego}" is a {sumo.vehicle.getVehicleClass(name)}, which cannot carry the rig; name a road '
                    "vehicle (luxloop egos lists them), or set ego_any_class = true"
                )
            else:
                entries.rejected[label] = sumo.vehicle.getVehicleClass(name)
    raise TrafficInputError(_not_entered(sumo, ego, entries, sumo.simulation.getTime() - begin))


def await_busy_ego(
    sumo: Any,
    required: int,
    range_m: float,
    until: float,
    report: StartReport = ignore_status,
    *,
    any_class: bool = False,
) -> str:
    """Step SUMO until enough vehicles are around one that can be the ego, and return its SUMO id.

    Of several, it returns the one that has driven least, so that most of its route is left.

    Parameters
    ----------
    sumo, until, report, any_class
        As `await_ego`.
    required
        Number of other vehicles.
    range_m
        Sensor range [m].

    Raises
    ------
    TrafficInputError
        No vehicle had enough others around it.
    """
    begin, steps = sumo.simulation.getTime(), max(1, round(CHECK_S / sumo.simulation.getDeltaT()))
    most, busiest = -1, ""
    classes: dict[str, str] = {}
    while _goes_on(sumo, begin, until, report):
        for _ in range(steps):
            sumo.simulationStep()
        names = [name for name in sorted(sumo.vehicle.getIDList()) if sumo.vehicle.getPosition(name)[0] >= OFF_ROAD_M]
        classes.update({name: sumo.vehicle.getVehicleClass(name) for name in names if name not in classes})
        count = _counts(sumo, names, range_m)
        suitable = [any_class or not is_rejected(sumo.vehicle, name) for name in names]
        ready = [name for name, n, fits in zip(names, count, suitable, strict=True) if fits and n >= required]
        if ready:
            return str(min(ready, key=lambda name: (sumo.vehicle.getDistance(name), name)))
        for name, n, fits in zip(names, count, suitable, strict=True):
            if fits and n > most:
                most, busiest = n, name
    waited = sumo.simulation.getTime() - begin
    if most < 0:
        raise TrafficInputError(none_entered("first", waited, list(classes.values()), sumo.person.getIDCount()))
    longer = "" if sumo.simulation.getMinExpectedNumber() == 0 else ", or raise max_wait_s"
    raise TrafficInputError(
        f"min_vehicles = {required}: in {waited:.0f} s no vehicle had as many others within {range_m:.0f} m; the most "
        f'were {most}, around "{busiest}"; lower it{longer}'
    )


def none_entered(ego: str, waited: float, classes: Sequence[str], people: int = 0) -> str:
    """Return the message that no vehicle entered that can be the ego.

    Parameters
    ----------
    ego
        Selector.
    waited
        Simulated time [s].
    classes
        Classes of the vehicles that entered.
    people
        People in the net.
    """
    if classes:
        found = ", ".join(f"{list(classes).count(name)} {name}" for name in sorted(set(classes)))
        return (
            f'ego = "{ego}": the vehicles that entered in {waited:.0f} s ({found}) cannot carry the rig; add cars to '
            "the routes, or set ego_any_class = true"
        )
    only = f" ({people} people did)" if people else ""
    return f'ego = "{ego}": no vehicle entered in {waited:.0f} s{only}; add vehicles to the routes, or raise max_wait_s'


def _goes_on(sumo: Any, begin: float, until: float, report: StartReport) -> bool:
    """Return False after the time limit, or if no road user is left; before the first step SUMO may know of none."""
    now = sumo.simulation.getTime()
    report(
        StartStatus(f"SUMO runs until the ego enters, at most {until - begin:.0f} s", (now - begin) / (until - begin))
    )
    return bool(now < until and (now == begin or sumo.simulation.getMinExpectedNumber() > 0))


def _counts(sumo: Any, names: list[str], range_m: float) -> list[int]:
    """Return the number of other vehicles within a range of each vehicle, between front bumpers as SUMO searches."""
    place = np.array([sumo.vehicle.getPosition(name) for name in names]).reshape(-1, 2)
    if not len(place):
        return []
    return [int(n) - 1 for n in scipy.spatial.cKDTree(place).query_ball_point(place, range_m, return_length=True)]


def _not_entered(sumo: Any, ego: str, entries: Entries, waited: float) -> str:
    """Return the message that an ego did not enter, with the true reason."""
    selector, _, wanted = ego.partition(":")
    if selector == "first" or not (entries.suitable or entries.rejected):
        return none_entered(ego, waited, list(entries.rejected.values()), sumo.person.getIDCount())
    if selector == "route" and wanted in entries.rejected:
        return (
            f'ego = "{ego}": on this route only a {entries.rejected[wanted]} entered in {waited:.0f} s, which cannot '
            "carry the rig; name another route, or set ego_any_class = true"
        )
    names = ", ".join(list(entries.suitable)[:LISTED]) or "none that can carry the rig"
    ended = sumo.simulation.getMinExpectedNumber() == 0
    remedy = "no vehicle is left to enter, name one of them" if ended else "name one of them, raise max_wait_s"
    return f'ego = "{ego}" did not enter in {waited:.0f} s; these did: {names}; {remedy} or lower begin_s'
