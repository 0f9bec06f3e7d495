"""Draft of a scenario file."""

from dataclasses import dataclass, field
from typing import Any

from luxloop.scenarios.authoring.default_limits import default_limits


@dataclass(frozen=True, slots=True)
class Draft:
    """Choice of traffic, ego and window, before it is checked."""

    description: str
    traffic: dict[str, Any]
    """The table `[traffic]`."""
    duration_s: float
    seed: int
    choices: list[str] = field(default_factory=list)
    """Choices with their reasons, a sentence each."""

    def document(self) -> dict[str, Any]:
        """Return the content of the scenario file."""
        return {
            "description": self.description,
            "reason": "Written by luxloop new. Say here where the situation occurs, and which errors it reveals.",
            "seed": self.seed,
            "duration_s": self.duration_s,
            "traffic": self.traffic,
            "expect": default_limits(self.duration_s),
        }
