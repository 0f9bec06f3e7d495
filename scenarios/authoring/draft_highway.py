"""Drafts of scenarios from environments of highway-env."""

from collections.abc import Iterator
from typing import Any

from luxloop.scenarios.authoring.draft import Draft
from luxloop.scenarios.authoring.draft_options import DraftOptions
from luxloop.sim.highway.environment import make
from luxloop.sim.highway.highway_config import MOTORIST

SEEDS = 8
"""Seeds that are tried: in some, the ego crashes soon."""


def highway_drafts(env: str, options: DraftOptions) -> Iterator[Draft]:
    """Yield drafts with one seed after the other.

    Raises
    ------
    InputError
        An ego or a window was asked for.
    TrafficInputError
        There is no such environment.
    """
    options.refuse(
        "an environment of highway-env has its first agent as ego, from its start on; leave it out",
        *("--ego", "--begin", "--want", "--window"),
    )
    environment = make(env, {})
    limited = "other_vehicles_type" in environment.config
    environment.close()
    table: dict[str, Any] = {"kind": "highway-env", "env": env}
    table |= {"config": {"other_vehicles_type": MOTORIST}} if limited else {}
    drivers = (
        "Drivers: Motorist, which turns within the limits of tyres; highway-env's own do not."
        if limited
        else "Drivers: the environment does not let them be chosen."
    )
    for place in range(SEEDS):
        seed = options.seed + place
        yield Draft(
            description=f"highway-env's {env}.",
            traffic=table,
            duration_s=options.duration_s,
            seed=seed,
            choices=["Ego: the first agent, driven like the other vehicles.", drivers, f"Seed {seed}."],
        )
