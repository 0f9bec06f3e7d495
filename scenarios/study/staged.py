"""Staged scenes under the module name that study files use: `luxloop.scenarios.study.staged:hidden_behind_wall`."""

from luxloop.scenarios.study.scenes.behind_parked_truck import behind_parked_truck
from luxloop.scenarios.study.scenes.behind_row import behind_row
from luxloop.scenarios.study.scenes.behind_turning_bus import behind_turning_bus
from luxloop.scenarios.study.scenes.cut_in_past_lorry import cut_in_past_lorry
from luxloop.scenarios.study.scenes.hidden_behind_wall import hidden_behind_wall
from luxloop.scenarios.study.scenes.hidden_with_failed_unit import hidden_with_failed_unit
from luxloop.scenarios.study.scenes.partly_hidden import partly_hidden
from luxloop.scenarios.study.scenes.passed_by_bus import passed_by_bus
from luxloop.scenarios.study.scenes.past_house import past_house
from luxloop.scenarios.study.scenes.standing_car import standing_car

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
