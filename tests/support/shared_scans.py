"""Traffic and scans that are simulated once and played to every tracker that a module runs on them.

They do not depend on the tracker unless it controls the ego; tests of many trackers on one scene simulate it once.
The outputs of the shipped tracker, into which tests plant faults, are computed once in the same way.
"""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from hashlib import sha256
from typing import Any, NamedTuple

import pytest

from luxloop.scenarios.run import loop
from luxloop.scenarios.run.scan_source import ScannedFrame, ScanSource, ScanStart
from luxloop.tracker.records import StepTrace, Tracks
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig


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


class PlayedTracker:
    """The shipped tracker, which computes only what none with the same settings has computed for the same scans.

    Parameters
    ----------
    config
        Settings of the tracker.
    outputs
        Pickled outputs by a hash of the settings and all scans so far; completed by each tracker.
    """

    def __init__(self, config: TrackerConfig, outputs: dict[bytes, bytes]) -> None:
        self._tracker, self._outputs = Tracker(config), outputs
        self._key, self._missed = pickle.dumps(config), list[Scan]()

    def step(self, scan: Scan) -> tuple[Tracks, StepTrace]:
        """Return the output of the tracker for its next scan."""
        self._key = sha256(self._key + pickle.dumps(scan)).digest()
        if self._key not in self._outputs:
            for earlier in self._missed:
                self._tracker.step(earlier)
            self._missed.clear()
            self._outputs[self._key] = pickle.dumps(self._tracker.step(scan))
        else:
            self._missed.append(scan)
        return pickle.loads(self._outputs[self._key])


@contextmanager
def shared() -> Iterator[None]:
    """Share scans among all runs of the block that simulate in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "ScanSource", partial(PlayedScans, {}))
        yield
