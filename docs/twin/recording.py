"""Frames of an Ouster recording: PCAP with JSON metadata, read with ouster-sdk."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy
from twin.labels import View

from luxloop.arrays import Floats, Ints

NEAREST_M = 0.5
"""Shorter ranges are the sensor's own window."""


class RecordedFrame(NamedTuple):
    """Turn of the head, in the level frame of its `View`."""

    points_level: Floats
    """(N, 3) [m]."""
    ring: Ints
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
    scan = next(turn[0] for index, turn in enumerate(source) if index == view.frame)
    seen = scan.field("RANGE") > 1000.0 * NEAREST_M
    tilt = scipy.spatial.transform.Rotation.from_euler("ZYX", [0.0, view.pitch_deg, view.roll_deg], degrees=True)
    return RecordedFrame(
        points_level=tilt.apply(XYZLut(info)(scan)[seen]) + np.array([0.0, 0.0, view.height_m]),
        ring=np.nonzero(seen)[0],
        elevation_deg=np.asarray(info.beam_altitude_angles, dtype=np.float64),
        azimuth_deg=np.asarray(info.beam_azimuth_angles, dtype=np.float64),
        columns=int(info.format.columns_per_frame),
    )
