"""Scans of the simulator as fused scans 0x2205."""

import numpy as np
import numpy.typing as npt

from luxloop.sensor_model.formats.lux_fused_scan import (
    DIRT,
    FUSED,
    GROUND,
    LUX,
    POINT,
    RAIN,
    TRANSPARENT,
    UNIT,
    VEHICLE_FRAME,
    FusedScan,
)
from luxloop.sensor_model.formats.lux_scan_points import firing_time, ntp_time
from luxloop.sensor_model.rig.rig import Rig
from luxloop.tracker.scan import PointFlag, Scan

FIRST_DEVICE = 1
"""Device number of the first unit; 0 is the fusion system."""
FLAGS = {
    PointFlag.TRANSPARENT: TRANSPARENT, PointFlag.CLUTTER: RAIN, PointFlag.GROUND: GROUND, PointFlag.DIRT: DIRT,
}  # fmt: skip
"""Flags of points by those of scan messages."""

_MICROSECONDS = 1e6


def fused_scan(scan: Scan, rig: Rig, number: int = 0, *, sweep: bool = True) -> FusedScan:
    """Return a scan as one message, with positions from the rear axle in float32.

    Parameters
    ----------
    scan
        Points of the units of `rig`.
    number
        Number of the scan, modulo 2^16.
    sweep
        If False, all beams fire at the time of the scan, as with `SensorConfig.sweep`.

    Raises
    ------
    ValueError
        A unit is not in the rig, or a time lies before 1900.
    """
    if len(scan) and scan.unit.max() >= len(rig.mounts):
        raise ValueError(f"unit = {scan.unit.max()}: the rig has units 0 to {len(rig.mounts) - 1}")
    times = np.array([_limits(rig, unit, sweep) for unit in range(len(rig.mounts))])
    first = min([float(times[:, 0].min()), *scan.time_offset.astype(np.float64).tolist()])
    return FusedScan(
        start_ntp=ntp_time(scan.time + first),
        duration_us=round(_MICROSECONDS * (float(times[:, 1].max()) - first)),
        flags=FUSED | VEHICLE_FRAME,
        scan_number=number % 2**16,
        units=_units(scan.time, rig, number, times),
        points=_points(scan, rig, first),
    )


def _limits(rig: Rig, unit: int, sweep: bool) -> tuple[float, float]:
    """Return the firing times of the first and the last beam of a unit, relative to the scan's time [s]."""
    mount = rig.mounts[unit]
    start_deg, end_deg = max(fan.start_deg for fan in mount.model.fans), min(fan.stop_deg for fan in mount.model.fans)
    return firing_time(mount, start_deg, sweep), firing_time(mount, end_deg, sweep)


def _units(time: float, rig: Rig, number: int, limits: npt.NDArray[np.float64]) -> npt.NDArray[np.void]:
    units = np.zeros(len(rig.mounts), UNIT)
    units["device"], units["type"] = FIRST_DEVICE + np.arange(len(units)), LUX
    units["scan_number"] = number % 2**16
    for row, mount, (start, end) in zip(units, rig.mounts, limits, strict=True):
        fans = mount.model.fans
        row["start_rad"] = np.deg2rad(max(fan.start_deg for fan in fans))
        row["end_rad"] = np.deg2rad(min(fan.stop_deg for fan in fans))
        row["start_ntp"] = row["device_start_ntp"] = ntp_time(time + float(start))
        row["end_ntp"] = row["device_end_ntp"] = ntp_time(time + float(end))
        row["rate_hz"] = mount.model.scan_rate_hz
        row["yaw_rad"], row["pitch_rad"], row["roll_rad"] = np.deg2rad([mount.yaw_deg, mount.pitch_deg, mount.roll_deg])
        row["x_m"], row["y_m"], row["z_m"] = mount.x_m, mount.y_m, mount.z_m
    return units


def _points(scan: Scan, rig: Rig, first: float) -> npt.NDArray[np.void]:
    points = np.zeros(len(scan), POINT)
    points["x_m"] = scan.points_ego[:, 0] - np.float32(rig.rear_axle_x_m)
    points["y_m"], points["z_m"] = scan.points_ego[:, 1], scan.points_ego[:, 2]
    points["width_m"] = scan.echo_pulse_width
    points["device"], points["layer"], points["echo"] = FIRST_DEVICE + scan.unit, scan.layer, scan.echo
    points["offset_us"] = np.rint(_MICROSECONDS * (scan.time_offset.astype(np.float64) - first))
    for flag, written in FLAGS.items():
        points["flags"] |= np.where(scan.flags & flag, written, 0).astype(np.uint16)
    return points
