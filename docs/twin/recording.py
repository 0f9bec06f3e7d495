"""Frames of an Ouster recording: PCAP with JSON metadata, read with ouster-sdk."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import scipy
from twin.labels import View

Floats = npt.NDArray[np.float64]
NEAREST_M = 0.5
"""Shorter ranges are the sensor's own window."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrame:
    """Turn of the head, in the level frame of its `View`."""

    points_level: Floats
    """(N, 3) [m]."""
    ring: npt.NDArray[np.int64]
    """(N,) 0 is the highest ring, as in the metadata."""
    elevation_deg: Floats
    """(R,) of the rings, up positive."""
    azimuth_deg: Floats
    """(R,) offset of the rings from the azimuth of their column, clockwise positive."""
    columns: int
    """Columns of one turn."""


def load_frame(folder: Path, view: View) -> RecordedFrame:
    """Read the frame of a view from `<recording>.pcap` in a folder."""
    from ouster.sdk import open_source
    from ouster.sdk.core import XYZLut

    source = open_source(str(folder / f"{view.recording}.pcap"))
    info = source.sensor_info[0]
    for index, turn in enumerate(source):
        if index == view.frame:
            scan = turn[0]
            break
    seen = scan.field("RANGE") > 1000.0 * NEAREST_M
    ring, _ = np.nonzero(seen)
    return RecordedFrame(
        points_level=levelled(XYZLut(info)(scan)[seen], view),
        ring=ring,
        elevation_deg=np.asarray(info.beam_altitude_angles, dtype=np.float64),
        azimuth_deg=np.asarray(info.beam_azimuth_angles, dtype=np.float64),
        columns=int(info.format.columns_per_frame),
    )


def levelled(points_sensor: Floats, view: View) -> Floats:
    """Return points (N, 3) of the sensor's frame in the level frame [m]."""
    tilt = scipy.spatial.transform.Rotation.from_euler("ZYX", [0.0, view.pitch_deg, view.roll_deg], degrees=True)
    return np.asarray(tilt.apply(points_sensor) + np.array([0.0, 0.0, view.height_m]))
