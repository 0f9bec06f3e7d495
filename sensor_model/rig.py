"""Which units sit where on the ego, and the files that say so."""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from sensor_model.unit import Fan, UnitModel

SHIPPED = Path(__file__).parent
"""Home of the shipped `rigs/*.toml` and `units/*.toml`."""

_Record = TypeVar("_Record")
_MAX_UNITS = 255  # a point's unit is a byte


class RigError(Exception):
    """A rig or unit file is missing or wrong; the message is one line: file, key, value, remedy."""


@dataclass(frozen=True, slots=True)
class Mount:
    """A unit and its pose in the rear-axle frame: x forward, y left, z up from the ground.

    The unit's axes are turned by yaw about z, then pitch about y (positive looks down), then roll about x.
    """

    name: str
    model: UnitModel
    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float
    pitch_deg: float
    roll_deg: float


@dataclass(frozen=True, slots=True)
class Rig:
    """All units of the ego."""

    rear_axle_x_m: float
    """Where the rear axle is in the ego frame, whose origin is the box centre."""
    mounts: tuple[Mount, ...]

    def __post_init__(self) -> None:
        if not 0 < len(self.mounts) <= _MAX_UNITS:
            raise ValueError(f"{len(self.mounts)} [[unit]] tables: a rig has 1 to {_MAX_UNITS} units")


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
    table = _read(_find(name_or_path, "rig", folder))
    mounts = tuple(_mount(unit) for unit in table.tables("unit"))
    return table.build(Rig, rear_axle_x_m=table.number("rear_axle_x_m"), mounts=mounts)


def _mount(table: "_Table") -> Mount:
    return table.build(
        Mount,
        name=table.text("name"),
        model=_unit_model(_find(table.text("model"), "unit", table.file.parent)),
        x_m=table.number("x_m"),
        y_m=table.number("y_m"),
        z_m=table.number("z_m"),
        yaw_deg=table.number("yaw_deg"),
        pitch_deg=table.number("pitch_deg"),
        roll_deg=table.number("roll_deg"),
    )


def _unit_model(path: Path) -> UnitModel:
    table = _read(path)
    return table.build(
        UnitModel,
        range_min_m=table.number("range_min_m"),
        range_max_m=table.number("range_max_m"),
        pulse_length_m=table.number("pulse_length_m"),
        layer_elevation_deg=table.numbers("layer_elevation_deg"),
        layer_bias_m=table.numbers("layer_bias_m"),
        gain_azimuth_deg=table.numbers("gain_azimuth_deg"),
        fans=tuple(_fan(fan) for fan in table.tables("fan")),
    )


def _fan(table: "_Table") -> Fan:
    return table.build(
        Fan,
        layers=table.integers("layers"),
        start_deg=table.number("start_deg"),
        stop_deg=table.number("stop_deg"),
        step_deg=table.number("step_deg"),
        gain_percent=table.numbers("gain_percent"),
    )


def _find(name_or_path: str, kind: str, folder: Path) -> Path:
    """Resolve a shipped name, else a path relative to `folder`."""
    shipped = {path.stem: path for path in sorted((SHIPPED / f"{kind}s").glob("*.toml"))}
    path = shipped.get(name_or_path, folder / name_or_path)
    if not path.is_file():
        raise RigError(f"{path}: no such {kind} file; give a path, or one of: {', '.join(shipped)}")
    return path


def _read(path: Path) -> "_Table":
    try:
        return _Table(path, tomllib.loads(path.read_text(encoding="utf-8")))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError) as error:
        raise RigError(f"{path}: not readable as TOML ({error}); correct the file") from error


@dataclass(frozen=True, slots=True)
class _Table:
    """One table of a file. It knows where it stands and which of its keys were asked for."""

    file: Path
    values: dict[str, object]
    path: str = ""
    asked: set[str] = field(default_factory=set)

    def build(self, record: Callable[..., _Record], **fields: object) -> _Record:
        """Make the record, once it is sure that the table has no keys beyond those asked for."""
        for key in self.values:
            if key not in self.asked:
                raise self._error(key, f"unknown key; known here: {', '.join(sorted(self.asked))}")
        try:
            return record(**fields)
        except ValueError as error:
            raise RigError(f"{self.file}: {self.path}{error}") from error

    def number(self, key: str) -> float:
        value = self._value(key)
        if not _is_number(value):
            raise self._error(key, "give a number")
        return float(value)  # type: ignore[arg-type]

    def numbers(self, key: str) -> tuple[float, ...]:
        value = self._value(key)
        if not isinstance(value, list) or not all(map(_is_number, value)):
            raise self._error(key, "give a list of numbers")
        return tuple(float(number) for number in value)

    def integers(self, key: str) -> tuple[int, ...]:
        if not all(number.is_integer() for number in self.numbers(key)):
            raise self._error(key, "give a list of whole numbers")
        return tuple(int(number) for number in self.numbers(key))

    def text(self, key: str) -> str:
        value = self._value(key)
        if not isinstance(value, str):
            raise self._error(key, "give a text in quotes")
        return value

    def tables(self, key: str) -> "list[_Table]":
        value = self._value(key)
        if not isinstance(value, list) or not value or not all(isinstance(row, dict) for row in value):
            raise self._error(key, f"give at least one [[{key}]] table")
        return [_Table(self.file, row, f"{self.path}{key}[{i}].") for i, row in enumerate(value)]

    def _value(self, key: str) -> object:
        self.asked.add(key)
        return self.values.get(key)

    def _error(self, key: str, remedy: str) -> RigError:
        value = repr(self.values[key]) if key in self.values else "missing"
        return RigError(f"{self.file}: {self.path}{key} = {value}: {remedy}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < float("inf")
