"""Export of a run as a multi-channel OSI trace, an MCAP file.

| topic | message | content |
|---|---|---|
| `ground_truth` | `osi3.GroundTruth` | ego, actors and obstacles in the world frame |
| `lidar/UNIT` | `osi3.SensorData` | points of a unit as measured |
| `truth/lidar/UNIT` | `osi3.SensorData` | the same points with true ranges and object ids |
| `tracks` | `osi3.SensorData` | confirmed tracks in the ego frame |
| `tracks/world` | `osi3.TrafficUpdate` | confirmed tracks in the world frame |

Metadata, schemas and channels are those of ASAM OSI 3.8, OSI trace file formats, multi channel trace file format. Times
start at 0, as in the run; the file does not depend on the time of writing.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import betterosi as osi

from luxloop.scenarios.exchange.exported_run import confirmed_tracks
from luxloop.scenarios.exchange.osi import lidar_data, track_messages
from luxloop.scenarios.exchange.osi.base_values import SOURCE, TRACKS, TRACKS_WORLD, TRUTH, nanoseconds
from luxloop.scenarios.exchange.osi.ground_truth import ground_truth, stationary_objects
from luxloop.scenarios.grading.ownership import points_of_actors
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.sensor_model.rig.beams import unit_table

TRACE = "trace.mcap"
START = "1970-01-01T00:00:00Z"
"""Calendar time of time 0 of the simulation."""


class Sent(NamedTuple):
    """A message and its channel."""

    topic: str
    message: osi.GroundTruth | osi.SensorData | osi.TrafficUpdate
    description: str


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into a trace in an empty folder."""
    result = run.result
    metadata = {
        "zero_time": START,
        "creation_time": START,  # in simulated time: the same run gives the same file
        "description": f"{result.scenario}, seed {result.seed}: {result.config['description']}",
        "data_sources": f"{SOURCE} {result.versions.get('luxloop')}",
    }
    with osi.Writer(folder / TRACE, metadata=metadata, library=SOURCE) as writer:
        for time_ns, sent in _messages(run):
            writer.add(sent.message, sent.topic, time_ns, channel_description=sent.description)


def _messages(run: RecordedRun) -> Iterator[tuple[int, Sent]]:
    scans = run.scans()
    obstacles, units, axle = stationary_objects(scans.obstacles()), unit_table(run.rig), run.rig.rear_axle_x_m
    tracks, none = confirmed_tracks(run), run.result.tables["tracks"].iloc[:0]
    for frame, scan, truth in scans:
        time_ns, found = nanoseconds(frame.time), tracks.get(frame.index, none)
        points = points_of_actors(truth.actor_id, frame.actors.id)
        yield time_ns, Sent(TRUTH, ground_truth(frame, points, axle, obstacles), "truth in the world frame")
        for unit, mount in enumerate(run.rig.mounts):
            seen = lidar_data.measured(frame, scan, unit, mount, units)
            yield time_ns, Sent(f"lidar/{mount.name}", seen, "points as measured")
            known = lidar_data.true(frame, scan, truth, unit, mount, units)
            yield time_ns, Sent(f"truth/lidar/{mount.name}", known, "the same points with true ranges and object ids")
        sent = track_messages.sensor_data(frame, found, axle)
        yield time_ns, Sent(TRACKS, sent, "confirmed tracks in the ego frame")
        for update in track_messages.traffic_updates(frame, found):
            yield time_ns, Sent(TRACKS_WORLD, update, "confirmed tracks in the world frame")
