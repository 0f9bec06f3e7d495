"""Staged scenes under the module name that study files use: `luxloop.scenarios.study.staged:hidden_behind_wall`."""

from luxloop.scenarios.study.scenes.encounters import (
    behind_parked_truck,
    behind_turning_bus,
    cut_in_past_lorry,
    past_house,
)
from luxloop.scenarios.study.scenes.hidden_vehicles import behind_row, hidden_behind_wall, hidden_with_failed_unit
from luxloop.scenarios.study.scenes.partly_hidden import partly_hidden, passed_by_bus, standing_car

__all__ = [
    "behind_parked_truck",
    "behind_row",
    "behind_turning_bus",
    "cut_in_past_lorry",
    "hidden_behind_wall",
    "hidden_with_failed_unit",
    "partly_hidden",
    "passed_by_bus",
    "past_house",
    "standing_car",
]
