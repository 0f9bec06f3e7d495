"""What the files of a data set hold: every column with its type, unit and meaning."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from scenarios.grading.frame_tables import VIEW_NAMES
from scenarios.result import Result
from sensor_model.truth import Cause, Loss, Part
from sim.world import Kind
from tracker.records import MODELS

Values = dict[str, npt.NDArray[Any]]


class Column(NamedTuple):
    """One column of a file."""

    name: str
    kind: type | tuple[str, ...]
    """Number type, str, or the names of an enumeration in the order of their codes."""
    unit: str
    meaning: str

    @property
    def type(self) -> pa.DataType:
        """Arrow's type."""
        if isinstance(self.kind, tuple):
            return pa.dictionary(pa.int8(), pa.string())
        if self.kind is str:
            return pa.string()
        return pa.from_numpy_dtype(np.dtype(self.kind))

    @property
    def field(self) -> pa.Field:
        """Arrow's field; unit and meaning are kept in the file."""
        return pa.field(self.name, self.type, nullable=False, metadata={"unit": self.unit, "meaning": self.meaning})

    def array(self, values: npt.NDArray[Any]) -> pa.Array:
        """Arrow's array of values, enumerations as codes."""
        if isinstance(self.kind, tuple):
            return pa.DictionaryArray.from_arrays(pa.array(values.astype(np.int8)), pa.array(self.kind))
        return pa.array(values.astype(self.kind), self.type)

    def values(self, array: pa.Array) -> npt.NDArray[Any]:
        """Undo `array`: enumerations as codes (int8), texts as `np.str_`; the memory is one's own."""
        if isinstance(self.kind, tuple):
            codes = pc.index_in(array.cast(pa.string()), pa.array(self.kind))
            return np.array(codes, dtype=np.int8)
        return np.array(array, dtype=np.str_ if self.kind is str else self.kind)


def _names(enumeration: Any) -> tuple[str, ...]:
    return tuple(member.name.lower() for member in enumeration)


FRAME = Column("frame", np.int32, "", "number of the frame, from 0")

SCANS = (
    FRAME,
    Column("time_s", np.float64, "s", "time of the frame"),
    Column("ego_x_world_m", np.float64, "m", "true place of the ego's box centre, east"),
    Column("ego_y_world_m", np.float64, "m", "the same, north"),
    Column("ego_yaw_world_rad", np.float64, "rad", "true heading of the ego, counter-clockwise from east"),
    Column("ego_vx_world_mps", np.float64, "m/s", "true velocity of the ego, east"),
    Column("ego_vy_world_mps", np.float64, "m/s", "the same, north"),
    Column("ego_ax_world_mps2", np.float64, "m/s^2", "true acceleration of the ego, east"),
    Column("ego_ay_world_mps2", np.float64, "m/s^2", "the same, north"),
    Column("ego_yaw_rate_radps", np.float64, "rad/s", "true yaw rate of the ego, counter-clockwise"),
    Column("ego_length_m", np.float64, "m", "length of the ego's box"),
    Column("ego_width_m", np.float64, "m", "width of the ego's box"),
    Column("ego_height_m", np.float64, "m", "height of the ego's box"),
    Column("ego_changes_lane", np.bool_, "", "the simulator lets the ego jump to the next lane about now"),
    Column("ego_deviation_along_m", np.float64, "m", "how far the ego is ahead of where the simulator has it"),
    Column("ego_deviation_across_m", np.float64, "m", "the same, to the left"),
    Column("odom_x_m", np.float64, "m", "where odometry has the ego, along the x axis of the first frame's ego"),
    Column("odom_y_m", np.float64, "m", "the same, along its y axis"),
    Column("odom_yaw_rad", np.float64, "rad", "heading of the ego by odometry, 0 in the first frame"),
    Column("points", np.int32, "", "points of the scan"),
)

POINTS = (
    FRAME,
    Column("x_ego_m", np.float32, "m", "measured place, forward, in the ego frame of the point's own time"),
    Column("y_ego_m", np.float32, "m", "the same, to the left"),
    Column("z_ego_m", np.float32, "m", "the same, up from the ground"),
    Column("time_offset_s", np.float32, "s", "the point's own time after the frame's"),
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("layer", np.uint8, "", "layer of the LIDAR, 0 the lowest"),
    Column("echo", np.uint8, "", "echo of its beam, 0 the nearest"),
    Column("echo_pulse_width_m", np.float32, "m", "width of the echo"),
    Column("flags", np.uint16, "", "what the LIDAR says: 1 another echo behind, 2 clutter, 4 ground, 8 dirt"),
    Column("actor_id", np.int64, "", "truth: whom the point is on, as in the labels; -1 for none"),
    Column("part", _names(Part), "", "truth: what the beam met"),
    Column("cause", _names(Cause), "", "truth: why the point is there; all but clean are outliers of an outline"),
    Column("true_range_m", np.float32, "m", "truth: range without noise"),
)

LABELS = (
    FRAME,
    Column("actor_id", np.int64, "", "who, the same in all frames: the track's true id"),
    Column("name", str, "", "what the traffic simulator calls it"),
    Column("kind", _names(Kind), "", "what it is"),
    Column("graded", np.bool_, "", "an observation: a vehicle near enough with enough points, counted in the summary"),
    Column("x_ego_m", np.float64, "m", "box centre at the frame's time, forward of the ego's"),
    Column("y_ego_m", np.float64, "m", "the same, to the left"),
    Column("heading_ego_rad", np.float64, "rad", "heading, counter-clockwise from the ego's"),
    Column("x_world_m", np.float64, "m", "box centre, east"),
    Column("y_world_m", np.float64, "m", "the same, north"),
    Column("heading_world_rad", np.float64, "rad", "heading, counter-clockwise from east"),
    Column("length_m", np.float64, "m", "length of the box, without mirrors"),
    Column("width_m", np.float64, "m", "width of the box, without mirrors"),
    Column("height_m", np.float64, "m", "height of the box"),
    Column("corner_x_ego_m", np.float64, "m", "corner nearest to the ego's box centre, forward"),
    Column("corner_y_ego_m", np.float64, "m", "the same, to the left"),
    Column("corner_front", np.bool_, "", "whether that is a front corner"),
    Column("corner_left", np.bool_, "", "whether that is a left corner"),
    Column("view", VIEW_NAMES, "", "which sides of it returned points"),
    Column("faces", np.uint8, "", "the same as bits: 1 front, 2 left, 4 rear, 8 right"),
    Column("points", np.int32, "", "points on it"),
    Column("visible_fraction", np.float64, "", "rays that meet it, of those that would, were it alone"),
    Column("vx_world_mps", np.float64, "m/s", "velocity of the box centre, east"),
    Column("vy_world_mps", np.float64, "m/s", "the same, north"),
    Column("ax_world_mps2", np.float64, "m/s^2", "acceleration of the box centre, east"),
    Column("ay_world_mps2", np.float64, "m/s^2", "the same, north"),
    Column("yaw_rate_radps", np.float64, "rad/s", "yaw rate, counter-clockwise"),
    Column("mode", MODELS, "", "how it moves: standing, at constant velocity, accelerating (turns included)"),
    Column("articulation_rad", np.float64, "rad", "of a bent truck: tractor against trailer, whose the box is"),
    Column("changes_lane", np.bool_, "", "the simulator lets it jump to the next lane about now"),
    Column("deviation_along_m", np.float64, "m", "how far it is ahead of where the simulator has it"),
    Column("deviation_across_m", np.float64, "m", "the same, to the left"),
    Column("reflectivity", np.float64, "", "of its paint, diffuse, 0 to 1"),
)

HITS = (
    FRAME,
    Column("actor_id", np.int64, "", "as in the labels"),
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("hits", np.int32, "", "its rays that end on the actor, before any loss or noise"),
    Column("hits_alone", np.int32, "", "its rays that would, were the actor alone on the ground"),
)

LOSSES = (
    FRAME,
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("beam", np.int32, "", "number of its beam that has no echo of what it met"),
    Column("cause", _names(Loss), "", "why it has none"),
)

FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS, "hits": HITS, "losses": LOSSES}
"""Columns of each file."""


def readme(result: Result) -> str:
    """The README.md of a data set."""
    parts = [
        f"# {result.scenario}, seed {result.seed}",
        result.config["description"],
        "Simulated scans of a rig of LIDARs with their truth, written by luxloop. `summary.json` tells where they come "
        "from, how many vehicles, observations and frames there are, and which limits made a label an observation.",
        "Frames of reference: world (x east, y north) and ego (box centre of the ego on the ground, x forward, y left, "
        "z up). Angles are counter-clockwise. Points are as measured, each at its own time; labels are of the frame's.",
    ]
    for name, columns in FILES.items():
        rows = [f"| `{c.name}` | {_type_name(c)} | {c.unit} | {c.meaning} |" for c in columns]
        parts.append(
            "\n".join([f"## {name}.parquet", "", "| column | type | unit | meaning |", "|---|---|---|---|", *rows])
        )
    return "\n\n".join(parts) + "\n"


def _type_name(column: Column) -> str:
    if isinstance(column.kind, tuple):
        return " / ".join(column.kind)
    return "text" if column.kind is str else np.dtype(column.kind).name
