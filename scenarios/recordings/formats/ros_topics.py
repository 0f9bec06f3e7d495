"""Sweeps and poses of a recording of ROS topics, whichever container holds the messages."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from luxloop.scenarios.errors import InputError
from luxloop.scenarios.recordings.formats.ros_messages import POSES, SWEEPS, TRANSFORMS, pose_rows, short_type, sweep_of
from luxloop.scenarios.recordings.sweep import PoseList, Sweep

Messages = Callable[[list[str]], Iterable[tuple[str, float, Any]]]
"""Yields topic, time of logging [s] and message of the given topics, in the order of the recording."""


@dataclass(frozen=True, slots=True)
class RosTopics:
    """A recording of ROS topics, as a `RecordingSource`."""

    name: str
    """Name of the recording, for error messages."""
    types: dict[str, str]
    """Message type by topic, `package/Name`."""
    counts: dict[str, int]
    """Number of messages by topic."""
    topics: list[str]
    """Topics of the sweeps; the position of a topic is the number of its LIDAR."""
    messages: Messages

    @classmethod
    def of(
        cls, name: str, types: dict[str, str], counts: dict[str, int], wanted: list[str], messages: Messages
    ) -> "RosTopics":
        """Choose the topics of the sweeps: the wanted ones, or the only one.

        Raises
        ------
        InputError
            A topic does not exist or has no points, or the choice is not clear.
        """
        types = {topic: short_type(kind) for topic, kind in types.items()}
        known = sorted(topic for topic, kind in types.items() if kind in SWEEPS)
        for topic in wanted:
            if topic not in known:
                raise InputError(f"{name}: --topic {topic}: no PointCloud2 or LaserScan there; {_listed(known)}")
        if not wanted and len(known) != 1:
            raise InputError(f"{name}: name a topic of LIDAR points with --topic; {_listed(known)}")
        return cls(name, types, counts, wanted or known, messages)

    @property
    def count(self) -> int | None:
        """Number of messages with points."""
        return sum(self.counts[topic] for topic in self.topics)

    def sweeps(self) -> Iterator[Sweep]:
        """Yield the sweeps of all topics in the order of the recording."""
        for topic, logged_s, message in self.messages(self.topics):
            yield sweep_of(self.types[topic], message, logged_s, self.topics.index(topic))

    def poses(self, name: str) -> PoseList:
        """Return the poses of `TOPIC`, or of the transform `TOPIC:PARENT:CHILD`.

        Raises
        ------
        InputError
            There are no such poses.
        """
        topic, _, frames = name.partition(":")
        parent, _, child = frames.partition(":")
        kind = self.types.get(topic)
        known = sorted(name for name, kind in self.types.items() if kind in POSES)
        if kind not in POSES:
            raise InputError(f"{self.name}: {topic}: no poses there; {_listed(known)}")
        if kind == TRANSFORMS and not child:
            raise InputError(f"{self.name}: {topic}: holds transforms; name one as {topic}:PARENT:CHILD")
        found = PoseList()
        for _, logged_s, message in self.messages([topic]):
            for frame, body, row in pose_rows(kind, message, logged_s):
                if not child or (frame, body) == (parent.lstrip("/"), child.lstrip("/")):
                    found.frame = frame
                    found.rows.append(row)
        if not found.rows:
            raise InputError(f"{self.name}: {name}: has no poses")
        return found


def _listed(topics: list[str]) -> str:
    return f"the recording has {', '.join(topics)}" if topics else "the recording has none"
