"""Export of a run as streams of IBEO LUX messages.

| path | messages |
|---|---|
| `UNIT.lux` | 0x2202, a scan of the unit per frame |
| `fusion.lux` | 0x2205, the fused scan, and 0x2280, the confirmed tracks, per frame |

Each message follows a data header of the network protocol. Positions are in the vehicle frame, from the rear axle, on
the ground.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pandas as pd

from luxloop.arrays import Ints
from luxloop.scenarios.errors import OutputError
from luxloop.scenarios.exchange.exported_run import confirmed_tracks
from luxloop.scenarios.grading.plane_geometry import into_frame, turned
from luxloop.scenarios.offline.recorded_scans import RecordedRun
from luxloop.sensor_model.formats import lux_fused_scan, lux_object_list, lux_scan_message
from luxloop.sensor_model.formats.lux_fused_points import fused_scan
from luxloop.sensor_model.formats.lux_object_list import OBJECT, ObjectList
from luxloop.sensor_model.formats.lux_scan_points import ntp_time, scan_messages
from luxloop.sensor_model.formats.lux_scan_stream import DATA_HEADER_BYTES, data_header
from luxloop.sim.world import WorldFrame

FUSION = "fusion"
"""Name of the file of the fusion system, which is device 0; the units are the devices from 1."""
LARGEST_ID = 2**16 - 1


class Stream:
    """File of messages of one device.

    Parameters
    ----------
    file
        Open file.
    device
        Number of the device.
    """

    def __init__(self, file: BinaryIO, device: int) -> None:
        self._file, self._device, self._previous = file, device, 0

    def add(self, data_type: int, ntp: int, body: bytes) -> None:
        """Write a message after its data header."""
        self._file.write(data_header(self._previous, len(body), self._device, data_type, ntp) + body)
        self._previous = DATA_HEADER_BYTES + len(body)


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder.

    Raises
    ------
    OutputError
        A number does not fit into its field, such as a range over 655 m, or two units have the same file.
    """
    names = [FUSION, *(mount.name.replace("/", "_") for mount in run.rig.mounts)]
    if len(set(names)) < len(names):
        raise OutputError(f"{run.folder}: its rig has two units of one name, or one named {FUSION}; rename it")
    with ExitStack() as stack:
        files = [stack.enter_context((folder / f"{name}.lux").open("wb")) for name in names]
        fusion, *units = (Stream(file, device) for device, file in enumerate(files))
        try:
            _write(run, fusion, units)
        except ValueError as error:
            raise OutputError(f"{run.folder}: {error}; the LUX format cannot hold it") from error


def _write(run: RecordedRun, fusion: Stream, units: list[Stream]) -> None:
    """Write the messages of all units and of the fusion system."""
    tracks, table, sweep = confirmed_tracks(run), run.result.tables["tracks"], run.scenario.sensor.sweep
    first = table.groupby("track_id")["frame"].min()
    for frame, scan, _ in run.scans():
        for unit, message in zip(units, scan_messages(scan, run.rig, frame.index, sweep=sweep), strict=True):
            unit.add(lux_scan_message.DATA_TYPE, message.header.end_ntp, lux_scan_message.encode(message))
        fused = fused_scan(scan, run.rig, frame.index, sweep=sweep)
        fusion.add(lux_fused_scan.DATA_TYPE, fused.start_ntp, lux_fused_scan.encode(fused))
        found = tracks.get(frame.index, table.iloc[:0])
        age = frame.index - first.loc[found["track_id"]].to_numpy(np.int64)
        objects = _objects(frame, found, age, run.rig.rear_axle_x_m)
        fusion.add(lux_object_list.DATA_TYPE, objects.middle_ntp, lux_object_list.encode(objects))


def _objects(frame: WorldFrame, tracks: pd.DataFrame, age: Ints, rear_axle_x_m: float) -> ObjectList:
    """Return tracks as an object list: unclassified, without standard deviations and contours."""
    if len(tracks) and tracks["track_id"].max() > LARGEST_ID:
        raise ValueError(f"track_id = {tracks['track_id'].max()}: an object list has ids up to {LARGEST_ID}")
    objects = np.zeros(len(tracks), OBJECT)
    ego, middle = frame.ego, ntp_time(frame.time)
    pose = into_frame(tracks[["x_world_m", "y_world_m", "yaw_world_rad"]].to_numpy(np.float64), ego.pose_world)
    velocity = tracks[["vx_world_mps", "vy_world_mps"]].to_numpy(np.float64)
    back = np.full(len(tracks), -ego.pose_world[2])
    objects["id"], objects["age"], objects["ntp"] = tracks["track_id"], age, middle
    objects["center_m"] = objects["reference_m"] = pose[:, :2] - (rear_axle_x_m, 0.0)
    objects["size_m"], objects["course_rad"] = tracks[["length_m", "width_m"]].to_numpy(np.float64), pose[:, 2]
    objects["velocity_mps"] = turned(velocity, back)
    objects["relative_velocity_mps"] = turned(velocity - ego.velocity_world, back)
    return ObjectList(middle, objects)
