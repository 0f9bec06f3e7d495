"""Drafts of scenarios from SUMO traffic."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from luxloop.scenarios.authoring.draft import Draft
from luxloop.scenarios.authoring.draft_options import DraftOptions
from luxloop.scenarios.authoring.ego_survey import sensor_range
from luxloop.scenarios.authoring.sumo_survey import WINDOW_S, survey
from luxloop.scenarios.authoring.traffic_input import TrafficInput
from luxloop.scenarios.errors import InputError
from luxloop.scenarios.grading.grading_config import GradingConfig
from luxloop.sim.candidates.candidates import Candidates
from luxloop.sim.sumo.sumo_config import SumoTraffic

MARGIN_S = 2.0
"""[s] A candidate stays for longer than the scenario by this, since the survey has moments of one second."""


def sumo_drafts(given: TrafficInput, traffic: SumoTraffic, options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts, the best candidate first.

    Raises
    ------
    InputError
        No vehicle enters that can carry the rig, or not the one that was asked for.
    """
    if options.begin_s is not None:
        traffic = replace(traffic, begin_s=options.begin_s)
    near_m = GradingConfig().range_max_m
    found = survey(traffic, given.folder, options.seed, options.window_s, sensor_range(), near_m)
    for place, row in enumerate(_rows(found, given.name, options)):
        yield _draft(found, row, place, given, traffic, options, near_m)


def _rows(found: Candidates, name: str, options: DraftOptions) -> list[int]:
    """Return the candidates in their order, or the one that was asked for."""
    if not len(found):
        raise InputError(
            f"{name}: no vehicle enters within {options.window_s:g} s, and people cannot carry the rig; if vehicles "
            "depart later, give --begin shortly before their departure, or a longer --window"
        )
    rows = [int(row) for row in found.order(options.want, options.duration_s + MARGIN_S)]
    if options.ego:
        named = [row for row in rows if found.bodies[row].name == options.ego]
        if not named:
            raise InputError(f"--ego {options.ego}: did not enter within {options.window_s:g} s; see luxloop egos")
        rows = named
    suitable = [row for row in rows if not found.bodies[row].rejected]
    if not suitable:
        classes, counts = np.unique([found.bodies[row].vehicle_class for row in rows], return_counts=True)
        seen = ", ".join(f"{count} {name}" for name, count in zip(classes, counts, strict=True))
        raise InputError(f"{name}: the vehicles that enter within {options.window_s:g} s ({seen}) cannot carry the rig")
    return suitable


def _draft(
    found: Candidates,
    row: int,
    place: int,
    given: TrafficInput,
    traffic: SumoTraffic,
    options: DraftOptions,
    near_m: float,
) -> Draft:
    body = found.bodies[row]
    start, near = found.busiest_start(row, options.duration_s)
    later = start > found.enters_s[row] + 0.5 * MARGIN_S
    keys = ("config",) if traffic.config else ("net", "routes", "additional")
    table: dict[str, Any] = {
        "kind": "sumo",
        **{key: options.moved(getattr(traffic, key), given.folder) for key in keys},
    }
    table = {key: value for key, value in table.items() if value}
    table |= {"ego": f"vehicle:{body.name}"}
    table |= {"begin_s": options.begin_s} if options.begin_s is not None else {}
    table |= {"max_wait_s": options.window_s} if options.window_s > WINDOW_S else {}
    table |= {"frames_from_s": round(start, 3)} if later else {}
    count = int(found.suitable.sum())
    return Draft(
        description=f"Traffic of {given.name} by SUMO around the vehicle {body.name}.",
        traffic=table,
        duration_s=options.duration_s,
        seed=options.seed,
        choices=[
            f'Ego: vehicle "{body.name}" ({body.vehicle_class}), '
            + (
                "as asked for"
                if options.ego
                else f"number {place + 1} of {count} candidates by {options.want} "
                f"({options.window_s:g} s were surveyed; luxloop egos lists them)"
            )
            + ".",
            f"It stays {found.stay_s[row]:.0f} s, drives {found.distance_m[row]:.0f} m, turns in "
            f"{found.turns[row]:.0%} of the time and stops {found.stops[row]} times; {found.occlusion[row]:.0%} of its "
            "neighbours are behind others.",
            f"Window: from {start:.0f} s on SUMO's clock, {'the busiest of its stay' if later else 'where it enters'}, "
            f"with {near:.1f} vehicles within {near_m:g} m on average.",
        ],
    )
