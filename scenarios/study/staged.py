"""Staged scenes under the module name that study files use: `scenarios.study.staged:hidden_behind_wall`."""

from scenarios.study.scenes.occlusion_scenes import hidden_behind_wall, partly_hidden, standing_car

__all__ = ["hidden_behind_wall", "partly_hidden", "standing_car"]
