"""Export of a run as a T4 data set of TIER IV: the tables of nuScenes with extensions, one scene, one merged LIDAR.

| path | content |
|---|---|
| `annotation/*.json` | the thirteen mandatory tables |
| `data/LIDAR_CONCAT/N.pcd.bin` | points of a scan: float32 x, y, z [m], echo pulse width [m], ring |
| `map/none.png` | one empty pixel: there is no map |
| `status.json` | the run |
| `tracking_result.json` | confirmed tracks of the run in the format of nuScenes' tracking task |

Points and ego poses are those of `base_link`, the rear axle on the ground.
"""

from pathlib import Path

import numpy as np

from luxloop.scenarios.exchange.exported_run import cloud, confirmed_tracks
from luxloop.scenarios.exchange.nuscenes.nuscenes_export import MODALITIES, empty_png, rings, track_results, write_json
from luxloop.scenarios.exchange.nuscenes.nuscenes_rows import Row
from luxloop.scenarios.exchange.t4.t4_rows import CHANNEL, T4TableWriter
from luxloop.scenarios.offline.recorded_run import RecordedRun

MAP = "map/none.png"


def export(run: RecordedRun, folder: Path) -> None:
    """Write all frames of a run into an empty folder."""
    (folder / "data" / CHANNEL).mkdir(parents=True)
    tables, tracks = T4TableWriter(run, MAP), confirmed_tracks(run)
    results: dict[str, list[Row]] = {}
    for frame, scan, truth in run.scans():
        sample = tables.add(frame, truth)
        points = cloud(scan, rings(run, scan))
        points[:, 0] -= np.float32(run.rig.rear_axle_x_m)
        (folder / tables.filename(frame.index)).write_bytes(points.tobytes())
        results[sample] = track_results(sample, tracks.get(frame.index))
    (folder / "annotation").mkdir()
    for name, rows in tables.finish().items():
        write_json(folder / "annotation" / f"{name}.json", rows)
    write_json(folder / "tracking_result.json", {"meta": MODALITIES, "results": results})
    result = run.result
    source = {"scenario": result.scenario, "seed": result.seed, "luxloop": result.versions.get("luxloop")}
    write_json(folder / "status.json", source)
    (folder / "map").mkdir()
    (folder / MAP).write_bytes(empty_png())
