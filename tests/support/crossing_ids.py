"""Tracker with an injected bug, and a scene and study with which a search should find it.

The tracker permanently swaps the ids of two vehicles when the visible fractions of both are below 0.3.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

from support.stub_trackers import Perfect

from luxloop.scenarios.run import device

CROSSED = 0.3
"""Threshold of the visible fraction."""

SPEC = "crossing-ids"

SCENE = """\
description = "Two cars pass behind a wall one after the other; three further cars are irrelevant."
seed = 3
duration_s = 3.0

[traffic]
kind = "scripted"

[[traffic.actor]]
name = "ahead"
x_m = 15.0
y_m = 0.0
motion = [{ kind = "straight", speed_mps = 3.0 }]

[[traffic.actor]]
name = "first"
x_m = -16.0
y_m = 9.0
motion = [{ kind = "straight", speed_mps = 15.0 }]

[[traffic.actor]]
name = "oncoming"
x_m = 40.0
y_m = -4.0
yaw_deg = 180.0
motion = [{ kind = "straight", speed_mps = 9.0 }]

[[traffic.actor]]
name = "second"
x_m = -60.0
y_m = 9.0
motion = [{ kind = "straight", speed_mps = 15.0 }]

[[traffic.actor]]
name = "behind"
x_m = -15.0
y_m = 0.0

[[traffic.obstacle]]
corners_m = [[-6, 4], [4, 4]]
height_m = 4.0

[[traffic.obstacle]]
corners_m = [[-30, -14], [30, -14]]
height_m = 4.0

[sensor]
footprint = [1, 1]
sweep = false
"""

STUDY = """\
description = "Smallest case in which the tracker swaps the ids of two cars."
scenario = "scene.toml"
seeds = 2

[search]
metric = "track.id_switches"
max = 0
need = "an id outlives an occlusion"
trials = 25

[[vary]]
key = "traffic.actor[second].x_m"
low = -60.0
high = -22.0
neutral = -60.0

[[vary]]
key = "traffic.actor[oncoming].motion[0].speed_mps"
low = 3.0
high = 15.0
neutral = 9.0

[[vary]]
key = "traffic.actor[behind].x_m"
low = -30.0
high = -8.0
neutral = -15.0

[[vary]]
key = "noise.dropout.random_rate"
low = 0.0
high = 0.3
neutral = 0.01
"""


def write(folder: Path) -> Path:
    """Write the scene and its study; return the study's path."""
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    study = folder / "planted.toml"
    study.write_text(STUDY, encoding="utf-8")
    return study


@dataclass
class CrossingIds(Perfect):
    """Swaps the ids of two vehicles when the second of them crosses `CROSSED` while the first is still below."""

    below: set = field(default_factory=set)
    """Actors with a visible fraction below `CROSSED`."""
    id_of: dict = field(default_factory=dict)

    def see_truth(self, frame, truth):
        super().see_truth(frame, truth)
        hidden = (truth.visible_fraction < CROSSED) & (truth.hits_alone > 0)
        for actor, is_hidden in zip(frame.actors.id.tolist(), hidden.tolist(), strict=True):
            if not is_hidden:
                self.below.discard(actor)
            elif actor not in self.below:
                for other in sorted(self.below):
                    self.swap(actor, other)
                self.below.add(actor)

    def swap(self, a, b):
        self.id_of[a], self.id_of[b] = self.id_of.get(b, b), self.id_of.get(a, a)

    def estimates(self, index):
        return [replace(e, id=self.id_of.get(e.id, e.id)) for e in super().estimates(index)]


def make(config):
    """Return a tracker; it has no configuration."""
    del config
    return CrossingIds()


device.TRACKERS.core[SPEC] = make  # an oracle is no tracker that a user could name
