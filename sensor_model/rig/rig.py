"""Rigs: units and their mounting poses on the ego, and the rig files; docs/scenario-files.md explains every key."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from luxloop.sensor_model.rig.toml_table import RigError, Table, read_table
from luxloop.sensor_model.rig.unit import Fan, UnitModel
from luxloop.sensor_model.rig.unit_names import ALL_UNITS

__all__ = ["SHIPPED", "Mount", "Rig", "RigError", "load_rig", "load_unit"]

SHIPPED = Path(__file__).parents[1]
"""Folder of the shipped `rigs/*.toml` and `units/*.toml`."""

_MAX_UNITS = 255  # a point's unit is a byte


@dataclass(frozen=True, slots=True)
class Mount:
    """A unit and its pose in the rear-axle frame: x forward, y left, z up from the ground.

    The unit's axes are rotated by yaw about z, then pitch about y (positive looks down), then roll about x.
    """

    name: str
    model: UnitModel
    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    phase_ms: float = 0.0
    """Firing time of the unit's azimuth 0, relative to the frame's time."""

    def __post_init__(self) -> None:
        if not self.z_m > 0.0:
            raise ValueError(f"z_m = {self.z_m}: must be positive; it is the height above the ground")
        if not abs(self.phase_ms) <= 1000.0 / self.model.scan_rate_hz:
            raise ValueError(f"phase_ms = {self.phase_ms}: must be at most one scan, earlier or later")
        if self.name == ALL_UNITS:
            raise ValueError(f"name = {self.name!r}: reserved for all units; choose another")


@dataclass(frozen=True, slots=True)
class Rig:
    """All units of the ego; they have the same scan rate."""

    rear_axle_x_m: float
    """Position of the rear axle in the ego frame, whose origin is the box centre."""
    mounts: tuple[Mount, ...]

    def __post_init__(self) -> None:
        if not 0 < len(self.mounts) <= _MAX_UNITS:
            raise ValueError(f"{len(self.mounts)} [[unit]] tables: a rig has 1 to {_MAX_UNITS} units")
        names = [mount.name for mount in self.mounts]
        for i, mount in enumerate(self.mounts):
            if mount.name in names[:i]:
                raise ValueError(f"unit[{i}].name = {mount.name!r}: used by another unit; choose another")
            if mount.model.scan_rate_hz != self.scan_rate_hz:
                raise ValueError(
                    f"unit[{i}].model: scan_rate_hz = {mount.model.scan_rate_hz}, but unit[0] has {self.scan_rate_hz}: "
                    "choose models with the same scan rate"
                )

    @property
    def scan_rate_hz(self) -> float:
        """Scans per second, the same for all units."""
        return self.mounts[0].model.scan_rate_hz

    @property
    def range_max_m(self) -> float:
        """Longest range of any unit [m]."""
        return max(mount.model.range_max_m for mount in self.mounts)


def load_rig(name_or_path: str, folder: Path) -> Rig:
    """Read a rig and the unit models that it names.

    Parameters
    ----------
    name_or_path
        Name of a shipped rig ("srx_six_lux"), or the path of a rig file.
    folder
        Where relative paths start, usually the folder of the scenario file.

    Raises
    ------
    RigError
        A file is missing, or one of its keys is missing, unknown or out of range.
    """
    table = _read(name_or_path, "rig", folder)
    model, load = table.text("model", ""), cache(load_unit)  # most units are of one model, which is read once
    mounts = tuple(_mount(unit, model or None, load) for unit in table.tables("unit"))
    return table.record(Rig, mounts=mounts)


def _mount(table: Table, model: str | None, load: Callable[[str, Path], UnitModel]) -> Mount:
    return table.record(Mount, model=load(table.text("model", model), table.file.parent))


def load_unit(name_or_path: str, folder: Path) -> UnitModel:
    """Read a unit model, like `load_rig`."""
    table = _read(name_or_path, "unit", folder)
    gain = table.table("gain_percent")
    layers = len(table.numbers("layer_elevation_deg"))
    return table.record(
        UnitModel,
        pulse_sigma_m=table.number("pulse_sigma_m", 0.0),
        range_sigma_far_m=table.number("range_sigma_far_m", table.number("range_sigma_m")),
        layer_pulse_bias_m=table.numbers("layer_pulse_bias_m", [0.0] * layers),
        turns=table.integer("turns", 1),
        fans=tuple(fan.record(Fan, gain_percent=_column(gain, fan)) for fan in table.tables("fan")),
    )


def _column(gain: Table, fan: Table) -> tuple[float, ...]:
    """Return the column of [gain_percent] named by the fan."""
    name = fan.text("gain")
    if name not in gain.values:
        raise fan.error("gain", f"no such column; [gain_percent] has: {', '.join(gain.values)}")
    return gain.numbers(name)


def _read(name_or_path: str, kind: str, folder: Path) -> Table:
    """Read a rig or unit file; missing keys are taken from the file named by its key `like`."""
    table = read_table(_find(name_or_path, kind, folder))
    like = table.text("like", "")
    if not like:
        return table
    model = read_table(_find(like, kind, table.file.parent))
    if "like" in model.values:
        raise table.error("like", f"this {kind} is based on {model.values['like']!r} itself; name that one")
    return Table(table.file, {**model.values, **table.values}, read=table.read)


def _find(name_or_path: str, kind: str, folder: Path) -> Path:
    """Resolve a shipped name, or else a path relative to `folder`."""
    shipped = {path.stem: path for path in sorted((SHIPPED / f"{kind}s").glob("*.toml"))}
    path = shipped.get(name_or_path, folder / name_or_path)
    if not os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a name that is too long
        raise RigError(f"{path}: no such {kind} file; give a path, or one of: {', '.join(shipped)}")
    return path
