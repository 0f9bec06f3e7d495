"""Appearance of a recording: colours, legend, and layout of the viewer.

Rerun is imported lazily inside the functions, because its import takes half a second.
"""

from typing import TYPE_CHECKING

from luxloop.sensor_model.truth import Cause
from luxloop.tracker.records import MODEL_NAMES

if TYPE_CHECKING:
    import rerun as rr
    import rerun.blueprint as rrb
    from rerun.encodings import EntityPathLike

TRAIL_S = 3.0
"""Duration of the trail behind a track [s]."""
RINGS_M = (25.0, 50.0)
"""Radii of the circles around the ego, for scale [m]."""
WALL_TOP_M = 2.0
"""Maximum height of drawn walls [m]. Higher walls would hide the objects behind them."""
NAME_GAP_M = 1.5
"""Distance from a track's front to its name [m]."""

WHITE, GREY, DARK, YELLOW = (255, 255, 255), (95, 95, 105), (60, 64, 78), (255, 214, 0)
GREEN, BLUE, VIOLET = (46, 204, 113), (70, 130, 255), (177, 90, 230)
CYCLE = (GREEN, BLUE, VIOLET, (20, 200, 190), (177, 227, 72), (190, 150, 110))
"""Colour cycle of track ids, units and layers, without the colours of noise."""
HIDDEN, VISIBLE = (210, 60, 60), (235, 235, 235)
"""Colours of truth boxes with visible fractions 0 and 1."""
DIM = 0.5
"""Brightness of truth that is not graded, of tracks that are not confirmed, and of trails."""
CAUSES = {
    Cause.CLEAN: (110, 190, 255),
    Cause.MIRROR: (255, 0, 255),
    Cause.LAYER_OVERLAP: (255, 140, 0),
    Cause.RANGE_OUTLIER: (255, 40, 40),
    Cause.GHOST: (255, 130, 200),
    Cause.DOUBLED: (255, 225, 120),
    Cause.FALSE_ALARM: (200, 30, 90),
    Cause.RAIN: (120, 220, 220),
    Cause.SPRAY: (150, 190, 190),
    Cause.SNOW: (215, 235, 255),
    Cause.FOG: (165, 165, 175),
}
SHORT_NAMES = {"stationary": "st", "cv": "cv", "ca": "ca", "ctrv": "ctrv", "ctra": "ctra", "two-axle": "2ax"}
"""Short names of motion models, beside a track's id."""
MODEL_COLORS = dict(zip(MODEL_NAMES, CYCLE, strict=True))
BACKGROUND = 16
"""Class id of clean points on no actor; other points have their `Cause` as class id."""

PLOTS = {
    "plots/models_moving": MODEL_COLORS,
    "plots/models_standing": MODEL_COLORS,
    "plots/heading_error": {"fit heading (mod 90)": YELLOW, "track heading (mod 360)": GREEN},
    "plots/counts": {"graded vehicles": WHITE, "confirmed tracks": GREEN, "coasting tracks": BLUE},
    "plots/points": {"all": CAUSES[Cause.CLEAN], "noise": CAUSES[Cause.RANGE_OUTLIER]},
}
"""Lines of each plot with their colours, in the order of the logged values."""

CONTROL = "plots/control"
CONTROL_LINES = {"speed": WHITE, "speed wanted": GREEN, "gap seen": YELLOW}
"""Lines of the plot of a controlled ego."""

LEGEND = f"""\
Bird's-eye view; the **ego is the solid box**, heading up. Circles at {RINGS_M[0]:.0f} and {RINGS_M[1]:.0f} m.
- **Truth**: thin white boxes, red when occluded, dim when not graded
- **Fits**: thin yellow rectangles
- **Tracks**: thick coloured rectangles with id and selected motion model
  ({", ".join(SHORT_NAMES.values())}), an arrow of 1 s of travel and a trail of {TRAIL_S:.0f} s;
  thin and dim when tentative or coasting
- **Points**: blue on vehicles, grey elsewhere; noise is magenta for mirrors, orange inside the outline, red for range
  outliers and false alarms, pink for ghosts, yellow where units disagree, cyan for rain and spray. Tabs colour points
  by unit or layer instead.
"""


def layout(*, controlled: bool = False) -> "rrb.Blueprint":
    """Return the layout: scene on the left with a tab per colouring of the points, plots and events on the right.

    Parameters
    ----------
    controlled
        True adds the plot of a controlled ego.
    """
    import rerun.blueprint as rrb

    def plot(name: str, path: str, axis: rrb.ScalarAxis | None = None) -> rrb.TimeSeriesView:
        return rrb.TimeSeriesView(origin=path, name=name, axis_y=axis, plot_legend=rrb.Corner2D.LeftTop)

    probability, degrees = rrb.ScalarAxis(range=(0.0, 1.0)), rrb.ScalarAxis(range=(0.0, 10.0))
    columns = rrb.TextLogColumns(text_log_columns=["loglevel", "body"])
    scenes = rrb.Tabs(scene("Points by cause"), scene("Points by unit", "unit"), scene("Points by layer", "layer"))
    control = [plot("Ego: speeds [m/s] and gap [m]", CONTROL)] if controlled else []
    figures = rrb.Vertical(
        rrb.TextDocumentView(origin="legend", name="Legend"),
        plot("Model probability [0 to 1], mean over tracks of moving vehicles", "plots/models_moving", probability),
        plot("Model probability [0 to 1], mean over tracks of standing vehicles", "plots/models_standing", probability),
        plot("Heading errors of fits and tracks, median absolute [0 to 10 deg]", "plots/heading_error", degrees),
        rrb.Tabs(
            *control,
            rrb.TextLogView(origin="events", name="Events", columns=columns),
            plot("Vehicles and tracks", "plots/counts"),
            plot("Points", "plots/points"),
        ),
        row_shares=[1.1, 1, 1, 1, 1.3],
    )
    return arranged(scenes, figures)


def arranged(scenes: "rrb.Container | rrb.View", figures: "rrb.Container") -> "rrb.Blueprint":
    """Return a layout with the scene on the left and figures on the right; panels are collapsed.

    It is paused, because a viewer in a browser would otherwise follow the recording to its last frame.
    """
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        rrb.Horizontal(scenes, figures, column_shares=[1.7, 1]),
        rrb.TimePanel(timeline="sim_time", state="collapsed", play_state="paused"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def scene(name: str, color_by: str | None = None) -> "rrb.Spatial3DView":
    """Return a bird's-eye view that rotates with the ego; `color_by` selects another colouring of the points."""
    import rerun as rr
    import rerun.blueprint as rrb
    from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

    trail = rrb.VisibleTimeRanges(
        timeline="sim_time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_S),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    overrides: dict[EntityPathLike, rrb.VisibleTimeRanges | rrb.Visualizer] = {"world/odom/trails": trail}
    if color_by is not None:
        source = ComponentSourceKind.SourceComponent
        colors = VisualizerComponentMapping("Points3D:colors", source, source_component=f"by:{color_by}")
        overrides["world/ego/points"] = rr.Points3D.from_fields().visualizer(mappings=[colors])
    return rrb.Spatial3DView(
        origin="world/ego",
        contents="world/**",
        name=name,
        background=(22, 23, 28),
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=(-22, 0, 62), look_target=(4, 0, 0), eye_up=(0, 0, 1)),
        overrides=overrides,
    )


def point_classes() -> "rr.AnnotationContext":
    """Return the names and colours of the class ids of points."""
    import rerun as rr

    causes = [(int(cause), cause.name.lower(), color) for cause, color in CAUSES.items()]
    return rr.AnnotationContext([*causes, (BACKGROUND, "background", GREY)])
