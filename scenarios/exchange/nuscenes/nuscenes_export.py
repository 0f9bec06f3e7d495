"""Export of a run as a nuScenes folder: one scene, every scan a sample, one merged LIDAR.

| path | content |
|---|---|
| `v1.0-luxloop/*.json` | the thirteen tables of the nuScenes schema |
| `samples/LIDAR_TOP/*.pcd.bin` | points of a scan: float32 x, y, z [m], echo pulse width [m], ring |
| `maps/none.png` | the map that the schema needs: one empty pixel |
| `tracking_result.json` | confirmed tracks of the run in the format of the tracking task |

The points of all units are merged in the ego frame (centre of the ego's box, on the ground), so the calibrated sensor
is the identity. The ring is the layer plus the number of layers times the unit. Poses are the true ones in the world
frame.
"""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats32
from luxloop.scenarios.exchange.exported_run import TRACK_HEIGHT_M, cloud, confirmed_tracks
from luxloop.scenarios.exchange.nuscenes.nuscenes_rows import CHANNEL, Row, TableWriter, rotation
from luxloop.scenarios.offline.recorded_run import RecordedRun
from luxloop.tracker.scan import Scan

VERSION = "v1.0-luxloop"
MAP = "maps/none.png"
TRACK_NAME = "car"
"""Tracks have no class."""
MODALITIES = {"use_camera": False, "use_lidar": True, "use_radar": False, "use_map": False, "use_external": False}


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder."""
    clouds = folder / "samples" / CHANNEL
    clouds.mkdir(parents=True)
    tables = TableWriter(run, MAP)
    tracks = confirmed_tracks(run)
    results: dict[str, list[Row]] = {}
    for frame, scan, truth in run.scans():
        sample = tables.add(frame, truth)
        (folder / tables.filename(frame.index)).write_bytes(cloud(scan, rings(run, scan)).tobytes())
        results[sample] = track_results(sample, tracks.get(frame.index))
    (folder / VERSION).mkdir()
    for name, rows in tables.finish().items():
        write_json(folder / VERSION / f"{name}.json", rows)
    write_json(folder / "tracking_result.json", {"meta": MODALITIES, "results": results})
    (folder / "maps").mkdir()
    (folder / MAP).write_bytes(empty_png())


def rings(run: RecordedRun, scan: Scan) -> Floats32:
    """(N,) layer of each point plus the number of layers times its unit."""
    layers = max(len(mount.model.layer_elevation_deg) for mount in run.rig.mounts)
    return (layers * scan.unit.astype(np.int64) + scan.layer).astype(np.float32)


def write_json(path: Path, content: Any) -> None:
    """Write a table."""
    path.write_text(json.dumps(content, indent=0, allow_nan=False), encoding="utf-8")


def track_results(sample: str, tracks: pd.DataFrame | None) -> list[Row]:
    """Return the boxes of a sample; a track without a velocity has no such key."""
    rows = []
    for track in tracks.itertuples() if tracks is not None else ():
        row: Row = {
            "sample_token": sample,
            "translation": [track.x_world_m, track.y_world_m, 0.5 * TRACK_HEIGHT_M],
            "size": [track.width_m, track.length_m, TRACK_HEIGHT_M],
            "rotation": rotation(track.yaw_world_rad),
            "tracking_id": str(track.track_id),
            "tracking_name": TRACK_NAME,
            "tracking_score": 1.0,
        }
        velocity = [track.vx_world_mps, track.vy_world_mps]
        rows.append(row | ({"velocity": velocity} if np.isfinite(velocity).all() else {}))
    return rows


def empty_png() -> bytes:
    """Return a PNG of one black pixel, 8 bit greyscale."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0\0")) + chunk(b"IEND", b"")
