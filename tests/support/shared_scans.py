"""Traffic and scans that are simulated once and played to every tracker that a module runs on them.

They do not depend on the tracker unless it controls the ego; tests of many trackers on one scene simulate it once.
"""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple

import pytest

from luxloop.scenarios.run import loop
from luxloop.scenarios.run.scan_source import ScannedFrame, ScanSource, ScanStart


class Recording(NamedTuple):
    """A simulated run: pickled, so that no tracker changes the frames of the next one."""

    start: bytes
    facts: dict[str, Any]
    frames: list[bytes]


FACTS = ("origin", "warnings", "ego_name")
"""Attributes of a source that its reset sets."""


class PlayedScans(ScanSource):
    """A source that simulates only what none with the same traffic, rig, noise and seed has simulated before."""

    def __init__(self, recordings: dict[bytes, Recording], *settings: Any) -> None:
        super().__init__(*settings)
        self._recordings, self._settings = recordings, pickle.dumps(settings)

    def reset(self, seed: int) -> ScanStart:
        self._seed, self._index, self._is_live = seed, 0, False
        key = self._settings + str(seed).encode()
        if key not in self._recordings:
            self._is_live, start = True, super().reset(seed)
            facts = {name: getattr(self, name) for name in FACTS}
            self._recordings[key] = Recording(pickle.dumps(start), facts, [])
        self._played = self._recordings[key]
        vars(self).update(self._played.facts)
        return pickle.loads(self._played.start)

    def step(self) -> ScannedFrame:
        frames = self._played.frames
        if self._index == len(frames):
            self._simulate_played_frames()
            frames.append(pickle.dumps(super().step()))
        self._index += 1
        return pickle.loads(frames[self._index - 1])

    def _simulate_played_frames(self) -> None:
        """Bring the simulation, if none runs, to the end of the recording."""
        if not self._is_live:
            super().reset(self._seed)
            for _ in range(self._index):
                super().step()
            self._is_live = True


@contextmanager
def shared() -> Iterator[None]:
    """Share scans among all runs of the block that simulate in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "ScanSource", partial(PlayedScans, {}))
        yield
