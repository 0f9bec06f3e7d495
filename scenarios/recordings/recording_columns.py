"""Columns of the files of a recording: those of a data set that a real recording has, with the same names and types."""

from luxloop.scenarios.dataset import dataset_columns
from luxloop.scenarios.dataset.dataset_columns import Column, column_tables

SCAN_NAMES = ("frame", "time_s", "odom_x_m", "odom_y_m", "odom_yaw_rad", "points")
POINT_NAMES = (
    "frame", "x_ego_m", "y_ego_m", "z_ego_m", "time_offset_s", "unit", "layer", "echo", "echo_pulse_width_m", "flags",
)  # fmt: skip
LABEL_NAMES = (
    "frame", "actor_id", "name", "kind", "x_world_m", "y_world_m", "heading_world_rad", "length_m", "width_m",
    "height_m", "vx_world_mps", "vy_world_mps", "ax_world_mps2", "ay_world_mps2", "yaw_rate_radps", "mode",
)  # fmt: skip


def _chosen(columns: tuple[Column, ...], names: tuple[str, ...]) -> tuple[Column, ...]:
    by_name = {column.name: column for column in columns}
    return tuple(by_name[name] for name in names)


SCANS = _chosen(dataset_columns.SCANS, SCAN_NAMES)
POINTS = _chosen(dataset_columns.POINTS, POINT_NAMES)
LABELS = _chosen(dataset_columns.LABELS, LABEL_NAMES)
FILES = {"scans": SCANS, "points": POINTS, "labels": LABELS}
"""Columns of each file. `labels` exists only for recordings with true poses."""


def readme(text: str, files: dict[str, tuple[Column, ...]]) -> str:
    """Return the README.md of a recording.

    Parameters
    ----------
    text
        Origin of the recording.
    files
        Columns of the files it has.
    """
    parts = [
        "# Recording",
        text,
        "Recorded scans, imported by luxloop, in the layout of its data sets. `summary.json` holds the options of the "
        "import.",
        "Frames of reference: ego (x forward, y left, z up from the ground, at the origin of the odometry poses), and "
        "odometry (the ego frame of the first scan), which the labels call world. Angles are counter-clockwise. Points "
        "are as measured, each at its own time; labels are valid at the time of the frame.",
    ]
    return "\n\n".join([*parts, *column_tables(files)]) + "\n"
