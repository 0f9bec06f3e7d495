"""Scans of the simulator as LUX scan messages, and messages as points in the frames of their units."""

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.formats.lux_scan_message import (
    CM_PER_M,
    TICKS_PER_DEG,
    TICKS_PER_TURN,
    LuxHeader,
    LuxMessage,
)
from luxloop.sensor_model.rig.beams import unit_table
from luxloop.sensor_model.rig.rig import Mount, Rig
from luxloop.tracker.scan import Scan

NTP_EPOCH_S = 2_208_988_800
"""[s] from 1900, where NTP time starts, to 1970. Time 0 of a run is written as this time, so that none is negative."""

_NTP_PER_S = 2.0**32


def scan_messages(scan: Scan, rig: Rig, number: int = 0, *, sweep: bool = True) -> list[LuxMessage]:
    """Return a scan as one message per unit of the rig, in their order.

    Parameters
    ----------
    scan
        Points of the units of `rig`, placed by its mounting poses.
    number
        Number of the scan, modulo 2^16.
    sweep
        If False, all beams fire at the time of the scan, as with `SensorConfig.sweep`.

    Raises
    ------
    ValueError
        A unit is not in the rig, a time lies before 1900, or a range or width exceeds 655.35 m.
    """
    if len(scan) and scan.unit.max() >= len(rig.mounts):
        raise ValueError(f"unit = {scan.unit.max()}: the rig has units 0 to {len(rig.mounts) - 1}")
    units = unit_table(rig)
    messages = []
    for u, mount in enumerate(rig.mounts):
        rows = np.flatnonzero(scan.unit == u)
        points = elementwise.product(scan.points_ego[rows] - units.origin_ego[u], units.R_ego_unit[u])
        messages.append(_message(scan, rows, points, _header(scan, mount, number, len(rows), sweep)))
    return messages


def points_unit(message: LuxMessage, layer_elevation_deg: tuple[float, ...]) -> Floats:
    """Return (N, 3) points in the frame of the unit: x along the optical axis, y left, z up [m].

    Parameters
    ----------
    layer_elevation_deg
        Elevation of each layer, as in a unit file; the layers of a tilted mirror face vary and are not covered.

    Raises
    ------
    ValueError
        The message has a layer without an elevation.
    """
    if len(message) and message.layer.max() >= len(layer_elevation_deg):
        raise ValueError(f"layer = {message.layer.max()}: layer_elevation_deg has {len(layer_elevation_deg)} numbers")
    azimuth = np.deg2rad(message.azimuth_ticks / TICKS_PER_DEG)
    elevation = np.deg2rad(np.array(layer_elevation_deg))[message.layer]
    distance = message.range_cm / CM_PER_M
    level = distance * elementwise.cos(elevation)
    return np.stack(
        [level * elementwise.cos(azimuth), level * elementwise.sin(azimuth), distance * elementwise.sin(elevation)],
        axis=1,
    )


def _message(scan: Scan, rows: Ints, points: Floats, header: LuxHeader) -> LuxMessage:
    """Return the message of one unit with points (N, 3) in its frame, in firing order."""
    ticks = np.rint(np.rad2deg(elementwise.atan2(points[:, 1], points[:, 0])) * TICKS_PER_DEG)
    distance = np.rint(np.linalg.norm(points, axis=1) * CM_PER_M)
    width = np.rint(scan.echo_pulse_width[rows].astype(np.float64) * CM_PER_M)
    for name, values in (("range", distance), ("echo_pulse_width", width)):
        if len(rows) and not 0.0 <= values.min() <= values.max() <= np.iinfo(np.uint16).max:
            raise ValueError(f"{name} from {values.min() / CM_PER_M} to {values.max() / CM_PER_M} m: a scan message "
                             "has 0 to 655.35 m")  # fmt: skip
    order = np.lexsort((scan.echo[rows], scan.layer[rows], -ticks))
    rows = rows[order]
    return LuxMessage(
        header=header,
        layer=scan.layer[rows].astype(np.uint8),
        echo=scan.echo[rows].astype(np.uint8),
        flags=(scan.flags[rows] & 0xFF).astype(np.uint8),
        azimuth_ticks=ticks[order].astype(np.int16),
        range_cm=distance[order].astype(np.uint16),
        width_cm=width[order].astype(np.uint16),
        reserved=np.zeros(len(rows), dtype=np.uint16),
    )


def _header(scan: Scan, mount: Mount, number: int, points: int, sweep: bool) -> LuxHeader:
    start_deg = max(fan.start_deg for fan in mount.model.fans)
    end_deg = min(fan.stop_deg for fan in mount.model.fans)
    start_ntp, end_ntp = (ntp_time(scan.time + firing_time(mount, deg, sweep)) for deg in (start_deg, end_deg))
    return LuxHeader(
        scan_number=number % 2**16,
        scanner_status=0,
        sync_phase=0,
        start_ntp=start_ntp,
        end_ntp=end_ntp,
        ticks_per_turn=TICKS_PER_TURN,
        start_ticks=round(start_deg * TICKS_PER_DEG),
        end_ticks=round(end_deg * TICKS_PER_DEG),
        points=points,
        mount_yaw_ticks=round(mount.yaw_deg * TICKS_PER_DEG),
        mount_pitch_ticks=round(mount.pitch_deg * TICKS_PER_DEG),
        mount_roll_ticks=round(mount.roll_deg * TICKS_PER_DEG),
        mount_x_cm=round(mount.x_m * CM_PER_M),
        mount_y_cm=round(mount.y_m * CM_PER_M),
        mount_z_cm=round(mount.z_m * CM_PER_M),
        flags=0,
    )


def firing_time(mount: Mount, azimuth_deg: float, sweep: bool) -> float:
    """Return the nominal firing time of an azimuth relative to the scan's time [s]."""
    return (mount.phase_ms / 1000.0 - azimuth_deg / (360.0 * mount.model.scan_rate_hz)) if sweep else 0.0


def ntp_time(time: float) -> int:
    """Return a time of the run [s] as NTP time.

    Raises
    ------
    ValueError
        The time lies before 1900 or after 2036.
    """
    ntp = (NTP_EPOCH_S << 32) + round(time * _NTP_PER_S)
    if not 0 <= ntp < 2**64:
        raise ValueError(f"time = {time} s: outside NTP time, 1900 to 2036")
    return ntp
