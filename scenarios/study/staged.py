"""Staged scenes under the module name that study files use: `scenarios.study.staged:hidden_behind_wall`."""

from scenarios.study.scenes.hidden_behind_wall import hidden_behind_wall
from scenarios.study.scenes.partly_hidden import partly_hidden
from scenarios.study.scenes.standing_car import standing_car

__all__ = ["hidden_behind_wall", "partly_hidden", "standing_car"]
