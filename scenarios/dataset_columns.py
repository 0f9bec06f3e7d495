"""What the files of a data set hold: every column with its type, unit and meaning, and its values of one frame."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from scenarios.grading.frame import FrameGrade
from scenarios.grading.geometry import corner, into_frame, nearest_sign
from scenarios.grading.tables import VIEW_NAMES
from scenarios.result import Result
from sensor_model.truth import Cause, Part, ScanTruth
from sim.world import Kind, WorldFrame
from tracker.records import MODELS
from tracker.scan import Scan

Values = dict[str, npt.NDArray[Any]]


class Column(NamedTuple):
    """One column of a file."""

    name: str
    kind: type | tuple[str, ...]
    """Number type, or the names of an enumeration in the order of their codes."""
    unit: str
    meaning: str

    @property
    def type(self) -> pa.DataType:
        """Arrow's type."""
        if isinstance(self.kind, tuple):
            return pa.dictionary(pa.int8(), pa.string())
        return pa.from_numpy_dtype(np.dtype(self.kind))

    @property
    def field(self) -> pa.Field:
        """Arrow's field; unit and meaning are kept in the file."""
        return pa.field(self.name, self.type, nullable=False, metadata={"unit": self.unit, "meaning": self.meaning})

    def array(self, values: npt.NDArray[Any]) -> pa.Array:
        """Arrow's array of values, enumerations as codes."""
        if isinstance(self.kind, tuple):
            return pa.DictionaryArray.from_arrays(pa.array(values.astype(np.int8)), pa.array(self.kind))
        return pa.array(values.astype(self.kind))


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
    Column("ego_yaw_rate_radps", np.float64, "rad/s", "true yaw rate of the ego, counter-clockwise"),
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
    Column("points", np.int32, "", "points on it"),
    Column("visible_fraction", np.float64, "", "rays that meet it, of those that would, were it alone"),
    Column("vx_world_mps", np.float64, "m/s", "velocity of the box centre, east"),
    Column("vy_world_mps", np.float64, "m/s", "the same, north"),
    Column("mode", MODELS, "", "how it moves: standing, at constant velocity, accelerating (turns included)"),
    Column("articulation_rad", np.float64, "rad", "of a bent truck: tractor against trailer, whose the box is"),
)

FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS}
"""Columns of each file."""


def scan_values(frame: WorldFrame, scan: Scan) -> Values:
    """One row of `SCANS`."""
    ego = frame.ego
    row = [
        frame.index, frame.time, *ego.pose_world, *ego.velocity_world, ego.yaw_rate, *scan.ego_pose_odom, len(scan),
    ]  # fmt: skip
    return {column.name: np.array([value]) for column, value in zip(SCANS, row, strict=True)}


def point_values(frame: WorldFrame, scan: Scan, truth: ScanTruth) -> Values:
    """Rows of `POINTS` of one frame."""
    return {
        "frame": np.full(len(scan), frame.index),
        **dict(zip(("x_ego_m", "y_ego_m", "z_ego_m"), scan.points_ego.T, strict=True)),
        "time_offset_s": scan.time_offset,
        "unit": scan.unit,
        "layer": scan.layer,
        "echo": scan.echo,
        "echo_pulse_width_m": scan.echo_pulse_width,
        "flags": scan.flags,
        "actor_id": truth.actor_id,
        "part": truth.part,
        "cause": truth.cause,
        "true_range_m": truth.true_range,
    }


def label_values(frame: WorldFrame, truth: ScanTruth, grade: FrameGrade) -> Values:
    """Rows of `LABELS` of one frame."""
    actors = frame.actors
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    boxes_ego = np.column_stack([pose_ego, actors.size[:, :2]])
    sign = nearest_sign(boxes_ego)
    return {
        "frame": np.full(len(actors), frame.index),
        "actor_id": actors.id,
        "kind": actors.kind,
        "graded": grade.graded,
        **dict(zip(("x_ego_m", "y_ego_m", "heading_ego_rad"), pose_ego.T, strict=True)),
        **dict(zip(("x_world_m", "y_world_m", "heading_world_rad"), actors.pose_world.T, strict=True)),
        **dict(zip(("length_m", "width_m", "height_m"), actors.size.T, strict=True)),
        **dict(zip(("corner_x_ego_m", "corner_y_ego_m"), corner(boxes_ego, sign).T, strict=True)),
        "corner_front": sign[:, 0] > 0,
        "corner_left": sign[:, 1] > 0,
        "view": truth.view,
        "points": grade.points,
        "visible_fraction": truth.visible_fraction,
        **dict(zip(("vx_world_mps", "vy_world_mps"), actors.velocity_world.T, strict=True)),
        "mode": actors.mode,
        "articulation_rad": actors.articulation,
    }


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
    return " / ".join(column.kind) if isinstance(column.kind, tuple) else np.dtype(column.kind).name
