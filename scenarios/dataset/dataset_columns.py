"""Columns of the files of a data set, with type, unit and meaning."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from luxloop.scenarios.grading.articulated import ARTICULATION
from luxloop.scenarios.grading.frame_tables import VIEW_NAMES
from luxloop.scenarios.result import Result
from luxloop.sensor_model.truth import Cause, Loss, Part
from luxloop.sim.world import Kind
from luxloop.tracker.records import MODELS

Values = dict[str, npt.NDArray[Any]]


class Column(NamedTuple):
    """A column of a file."""

    name: str
    kind: type | tuple[str, ...]
    """Number type, str, or names of an enumeration in the order of its codes."""
    unit: str
    meaning: str

    @property
    def type(self) -> pa.DataType:
        """Arrow type."""
        if isinstance(self.kind, tuple):
            return pa.dictionary(pa.int8(), pa.string())
        if self.kind is str:
            return pa.string()
        return pa.from_numpy_dtype(np.dtype(self.kind))

    @property
    def field(self) -> pa.Field:
        """Arrow field, with unit and meaning as metadata."""
        return pa.field(self.name, self.type, nullable=False, metadata={"unit": self.unit, "meaning": self.meaning})

    def array(self, values: npt.NDArray[Any]) -> pa.Array:
        """Return values as an Arrow array; enumerations are given as codes."""
        if isinstance(self.kind, tuple):
            return pa.DictionaryArray.from_arrays(pa.array(values.astype(np.int8)), pa.array(self.kind))
        return pa.array(values.astype(self.kind), self.type)

    def values(self, array: pa.Array) -> npt.NDArray[Any]:
        """Return an Arrow array as a new numpy array: enumerations as codes (int8), texts as `np.str_`.

        Raises
        ------
        ValueError
            A cell is empty, or is no value of the column.
        """
        if array.null_count:
            raise ValueError(f"column {self.name} has an empty cell")
        if isinstance(self.kind, tuple):
            codes = pc.index_in(array.cast(pa.string()), pa.array(self.kind))
            if codes.null_count:
                raise ValueError(f"column {self.name} has a value that is none of {', '.join(self.kind)}")
            return np.array(codes, dtype=np.int8)
        if self.kind is str:
            return np.array(array.cast(pa.string()), dtype=np.str_)
        return np.array(array.cast(self.type), dtype=self.kind)


def _names(enumeration: Any) -> tuple[str, ...]:
    return tuple(member.name.lower() for member in enumeration)


FRAME = Column("frame", np.int32, "", "number of the frame, from 0")

SCANS = (
    FRAME,
    Column("time_s", np.float64, "s", "time of the frame"),
    Column("ego_x_world_m", np.float64, "m", "true position of the ego's box centre, east"),
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
    Column("ego_changes_lane", np.bool_, "", "the simulator moves the ego to the next lane at about this time"),
    Column("ego_deviation_along_m", np.float64, "m", "deviation of the ego from the simulator's position, forward"),
    Column("ego_deviation_across_m", np.float64, "m", "the same, to the left"),
    Column("ego_ground_z_m", np.float64, "m", "height of the road under the ego"),
    Column("ego_pitch_rad", np.float64, "rad", "pitch of the ego's body against the horizontal, front down"),
    Column("ego_roll_rad", np.float64, "rad", "roll of the ego's body against the horizontal, right side down"),
    Column("odom_x_m", np.float64, "m", "position of the ego by odometry, x forward in the first frame"),
    Column("odom_y_m", np.float64, "m", "the same, y to the left in the first frame"),
    Column("odom_yaw_rad", np.float64, "rad", "heading of the ego by odometry, 0 in the first frame"),
    Column("points", np.int32, "", "number of points of the scan"),
)

POINTS = (
    FRAME,
    Column("x_ego_m", np.float32, "m", "measured position, forward, in the ego frame at the time of the point"),
    Column("y_ego_m", np.float32, "m", "the same, to the left"),
    Column("z_ego_m", np.float32, "m", "the same, up from the ground"),
    Column("time_offset_s", np.float32, "s", "time of the point minus time of the frame"),
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("layer", np.uint8, "", "layer of the LIDAR, from 0, the lowest"),
    Column("echo", np.uint8, "", "echo of its beam, from 0, the nearest"),
    Column("echo_pulse_width_m", np.float32, "m", "width of the echo"),
    Column("flags", np.uint16, "", "flags set by the LIDAR: 1 another echo behind, 2 clutter, 4 ground, 8 dirt"),
    Column("actor_id", np.int64, "", "truth: id of the actor that was hit, as in the labels; -1 for none"),
    Column("part", _names(Part), "", "truth: part of the actor or scene that was hit"),
    Column("cause", _names(Cause), "", "truth: cause of the point; all except clean are outliers"),
    Column("true_range_m", np.float32, "m", "truth: range without noise"),
)

LABELS = (
    FRAME,
    Column("actor_id", np.int64, "", "id of the actor, constant over all frames: true track id"),
    Column("name", str, "", "name in the traffic simulator"),
    Column("kind", _names(Kind), "", "kind of actor"),
    Column(
        "graded",
        np.bool_,
        "",
        "true for an observation: a vehicle in range with enough points",
    ),
    Column("x_ego_m", np.float64, "m", "box centre at the time of the frame, relative to the ego's, forward"),
    Column("y_ego_m", np.float64, "m", "the same, to the left"),
    Column("heading_ego_rad", np.float64, "rad", "heading relative to the ego's, counter-clockwise"),
    Column("x_world_m", np.float64, "m", "box centre, east"),
    Column("y_world_m", np.float64, "m", "the same, north"),
    Column("heading_world_rad", np.float64, "rad", "heading, counter-clockwise from east"),
    Column("length_m", np.float64, "m", "length of the box, without mirrors"),
    Column("width_m", np.float64, "m", "width of the box, without mirrors"),
    Column("height_m", np.float64, "m", "height of the box"),
    Column("corner_x_ego_m", np.float64, "m", "corner nearest to the ego's box centre, forward"),
    Column("corner_y_ego_m", np.float64, "m", "the same, to the left"),
    Column("corner_front", np.bool_, "", "true if that is a front corner"),
    Column("corner_left", np.bool_, "", "true if that is a left corner"),
    Column("view", VIEW_NAMES, "", "sides of the vehicle that returned points"),
    Column("faces", np.uint8, "", "the same as bits: 1 front, 2 left, 4 rear, 8 right"),
    Column("points", np.int32, "", "number of points on the actor"),
    Column(
        "visible_fraction",
        np.float64,
        "",
        "fraction of its rays that no occluder blocks",
    ),
    Column("vx_world_mps", np.float64, "m/s", "velocity of the box centre, east"),
    Column("vy_world_mps", np.float64, "m/s", "the same, north"),
    Column("ax_world_mps2", np.float64, "m/s^2", "acceleration of the box centre, east"),
    Column("ay_world_mps2", np.float64, "m/s^2", "the same, north"),
    Column("yaw_rate_radps", np.float64, "rad/s", "yaw rate, counter-clockwise"),
    Column("mode", MODELS, "", "motion model: stationary, constant velocity, or accelerating (including turns)"),
    Column(
        "articulation_rad",
        np.float64,
        "rad",
        "angle at the first joint: tractor relative to trailer; the box is the trailer's",
    ),
    *(
        Column(
            name, np.float64, "rad", "the same at the next joint of a tram or train; the box is its middle section's"
        )
        for name in ARTICULATION[1:]
    ),
    Column("changes_lane", np.bool_, "", "the simulator moves it to the next lane at about this time"),
    Column("deviation_along_m", np.float64, "m", "deviation from the simulator's position, forward"),
    Column("deviation_across_m", np.float64, "m", "the same, to the left"),
    Column("ground_z_m", np.float64, "m", "height of the road under it"),
    Column("pitch_rad", np.float64, "rad", "pitch of its body against the horizontal, front down"),
    Column("roll_rad", np.float64, "rad", "roll of its body against the horizontal, right side down"),
    Column("reflectivity", np.float64, "", "diffuse reflectivity of the paint, 0 to 1"),
)

HITS = (
    FRAME,
    Column("actor_id", np.int64, "", "as in the labels"),
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("hits", np.int32, "", "number of its rays that hit the actor, before losses and noise"),
    Column("hits_alone", np.int32, "", "number of its rays that would hit it without other objects"),
)

LOSSES = (
    FRAME,
    Column("unit", np.uint8, "", "number of the LIDAR in the rig"),
    Column("beam", np.int32, "", "number of the beam without an echo of the object that it hit"),
    Column("cause", _names(Loss), "", "cause of the loss"),
)

OBSTACLES = (
    Column("obstacle", np.int32, "", "number of the obstacle, from 0; its corners follow one another"),
    Column("x_world_m", np.float64, "m", "corner, east; two corners make a wall, more a closed polygon"),
    Column("y_world_m", np.float64, "m", "the same, north"),
    Column("base_m", np.float64, "m", "height of the lower edge above the ground"),
    Column("top_m", np.float64, "m", "height of the upper edge above the ground"),
    Column("reflectivity", np.float64, "", "diffuse reflectivity of its faces, 0 to 1"),
)

FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS, "hits": HITS, "losses": LOSSES}
"""Columns of each file with rows of frames; `OBSTACLES` are constant."""


def readme(result: Result) -> str:
    """Return the text of the README.md of a data set."""
    parts = [
        f"# {result.scenario}, seed {result.seed}",
        result.config["description"],
        "Simulated scans of a rig of LIDARs with their truth, written by luxloop. `summary.json` holds the "
        "scenario, the numbers of vehicles, observations and frames, and the limits that define an observation.",
        "Frames of reference: world (x east, y north) and ego (box centre of the ego on the ground, x forward, y left, "
        "z up). Angles are counter-clockwise. Points are as measured, each at its own time; labels are valid at the "
        "time of the frame.",
    ]
    return "\n\n".join([*parts, *column_tables({**FILES, "obstacles": OBSTACLES})]) + "\n"


def column_tables(files: Mapping[str, Sequence[Column]]) -> list[str]:
    """Return a section of Markdown for each file, with a table of its columns."""
    sections = []
    for name, columns in files.items():
        rows = [f"| `{c.name}` | {_type_name(c)} | {c.unit} | {c.meaning} |" for c in columns]
        sections.append(
            "\n".join([f"## {name}.parquet", "", "| column | type | unit | meaning |", "|---|---|---|---|", *rows])
        )
    return sections


def _type_name(column: Column) -> str:
    if isinstance(column.kind, tuple):
        return " / ".join(column.kind)
    return "text" if column.kind is str else np.dtype(column.kind).name
