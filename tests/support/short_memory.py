"""Tracker that forgets ids after a known time: it knows the truth, and gives a hidden vehicle a new id."""

from dataclasses import dataclass, field, replace
from pathlib import Path

from support.stub_trackers import Perfect

from luxloop.scenarios.run import device

MEMORY_FRAMES = 13
"""Most frames without a point after which an id is kept; 13 are 1.04 s."""

SPEC = "short-memory"

STUDY = """\
description = "Time hidden after which half of the ids are lost, by speed."
scenario = "luxloop.scenarios.study.staged:hidden_behind_wall"
seeds = 3

[fixed]
manoeuvre = "keeps speed"
"sensor.footprint" = [1, 1]
"sensor.sweep" = false

[threshold]
key = "occlusion_s"
metric = "track.occlusion_survival"
runs = 8

[[vary]]
key = "occlusion_s"
low = 0.4
high = 1.8

[[vary]]
key = "speed_mps"
values = [10.0, 20.0]
"""


def write(folder: Path) -> Path:
    """Write the study; return its path."""
    study = folder / "memory.toml"
    study.write_text(STUDY, encoding="utf-8")
    return study


@dataclass
class ShortMemory(Perfect):
    """Gives a vehicle a new id when it is seen again after more than `MEMORY_FRAMES`."""

    unseen: dict = field(default_factory=dict)
    """Frames since the last point, by actor."""
    lives: dict = field(default_factory=dict)
    """Number of ids of each actor so far."""

    def see_truth(self, frame, truth):
        super().see_truth(frame, truth)
        for actor, points in self.points[-1].items():
            if points and self.unseen.get(actor, 0) > MEMORY_FRAMES:
                self.lives[actor] = self.lives.get(actor, 0) + 1
            self.unseen[actor] = 0 if points else self.unseen.get(actor, 0) + 1

    def estimates(self, index):
        return [replace(e, id=e.id + 1000 * self.lives.get(e.id, 0)) for e in super().estimates(index)]


def make(config):
    """Return a tracker; it has no configuration."""
    del config
    return ShortMemory()


device.TRACKERS.core[SPEC] = make  # an oracle is no tracker that a user could name
