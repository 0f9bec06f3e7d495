"""Names, units and meanings of the `track` metrics.

`BANDED` metrics exist for all graded vehicles, and with an end of `BANDS` for a part of them, as in
`track.missed_share.by_class.bus`.
"""

from collections.abc import Iterator
from itertools import product

from luxloop.scenarios.grading.metric_definition import Definition
from luxloop.sensor_model.truth import View
from luxloop.sim.world import VEHICLE_KINDS, Kind

RANGE_BANDS = {"0_15": (0.0, 15.0), "15_30": (15.0, 30.0), "30_50": (30.0, 50.0)}
"""Bands of the distance from the ego's centre to the vehicle's [m], the upper end excluded."""

VIEWS = {View.L_SHAPE: "l_shape", View.SIDE: "side", View.REAR: "rear", View.FRONT: "front"}

SEEN = (*VIEWS.values(), "none")
"""Views of observations; `none` has too few points on every face."""

CLASSES = tuple(kind.name.lower() for kind in Kind if kind in VEHICLE_KINDS)
"""Classes of graded vehicles."""

BANDS = (
    *(f"by_range.{band}" for band in RANGE_BANDS),
    *(f"by_class.{name}" for name in CLASSES),
    *(f"by_view.{view}" for view in SEEN),
)
"""Ends of the names of banded metrics."""

SCORES = (
    Definition("track.hota", "1", "higher order tracking accuracy"),
    Definition("track.deta", "1", "detection accuracy of HOTA"),
    Definition("track.assa", "1", "association accuracy of HOTA"),
    Definition("track.loca", "1", "localisation accuracy of HOTA: mean overlap of matched pairs"),
    Definition("track.mota", "1", "CLEAR multiple object tracking accuracy"),
    Definition("track.idf1", "1", "F1 score of identities"),
    Definition("track.id_switches", "count", "changes of the track that hits a vehicle (CLEAR)"),
    Definition("track.id_switches_in_view", "count", "id switches with the vehicle in view all the time"),
    Definition("track.fragments", "count", "interruptions of a vehicle's track (CLEAR)"),
    Definition("track.missed", "count", "graded vehicles without a track, summed over frames (CLEAR)"),
    Definition("track.false", "count", "tracks that hit no vehicle, summed over frames (CLEAR)"),
)

FALSE = (
    Definition("track.false_on_nothing", "count", "false tracks that overlap no vehicle"),
    Definition("track.false_ill_fitting", "count", "false tracks that overlap a vehicle by less than a hit"),
    Definition("track.false_duplicate", "count", "false tracks in the place of a vehicle that another track hits"),
    Definition("track.false_share", "1", "false tracks over graded vehicles, both summed over frames"),
)

MISSED = (
    Definition("track.missed_share", "1", "graded vehicles without a hit over all, both summed over frames"),
    Definition("track.missed_share_standing", "1", "the same of vehicles that have stood since they came into sight"),
    Definition("track.missed_share_long", "1", "the same of vehicles longer than 6 m"),
)

CONFIRMATION = (
    Definition("track.time_to_confirm_s", "s", "time from a vehicle's first graded frame to its first hit, median"),
    Definition("track.time_to_confirm_p90_s", "s", "the same, 90th percentile"),
    Definition("track.never_confirmed", "1", "share of graded vehicles that no track ever hits"),
)

GOSPA = (
    Definition("track.gospa_m", "m", "GOSPA of graded vehicles and tracks, mean over frames"),
    Definition("track.gospa_localisation_m2", "m^2", "part of squared GOSPA by distances of located vehicles"),
    Definition("track.gospa_missed_m2", "m^2", "part of squared GOSPA by missed vehicles"),
    Definition("track.gospa_false_m2", "m^2", "part of squared GOSPA by false tracks"),
)

OCCLUSION = (
    Definition("track.occlusion_survival", "1", "occlusions of graded vehicles survived by the track's id"),
    Definition("track.hidden_2s_survival", "1", "the same for occlusions of at most 2 s"),
    Definition("track.reacquire_s", "s", "mean time until a track follows an occluded vehicle again"),
    Definition("track.reappearance_error_m", "m", "mean error of that track's centre at this time"),
)

HEADING = (
    Definition("track.heading_abs_mean_deg", "deg", "mean absolute heading error modulo 360, moving vehicles"),
    Definition("track.heading_abs_p90_deg", "deg", "the same, 90th percentile"),
    Definition("track.heading_flip_rate", "1", "headings more than 90 degrees off, moving vehicles"),
    Definition(
        "track.standing_heading_abs_mean_deg", "deg", "mean absolute heading error modulo 180, standing vehicles"
    ),
)

MOTION = (
    Definition("track.velocity_abs_mean_mps", "m/s", "mean norm of the velocity error"),
    Definition("track.moving_velocity_abs_mean_mps", "m/s", "the same of moving vehicles"),
    Definition("track.standing_speed_mean_mps", "m/s", "mean speed of tracks on standing vehicles"),
    Definition("track.speed_abs_mean_mps", "m/s", "mean absolute error of the speed"),
    Definition("track.speed_mean_mps", "m/s", "mean error of the speed"),
    Definition("track.acceleration_abs_mean_mps2", "m/s^2", "mean norm of the acceleration error, moving vehicles"),
)

SIZE = (
    Definition("track.length_mean_m", "m", "mean error of the length"),
    Definition("track.length_abs_mean_m", "m", "mean absolute error of the length"),
    Definition("track.width_mean_m", "m", "mean error of the width"),
    Definition("track.width_abs_mean_m", "m", "mean absolute error of the width"),
)

OVERALL = (*SCORES, *FALSE, *MISSED, *CONFIRMATION, *GOSPA, *OCCLUSION, *HEADING, *MOTION, *SIZE)
"""Metrics of all graded vehicles of a run."""

BANDED_NAMES = (
    "track.missed_share",
    "track.time_to_confirm_s",
    "track.gospa_m",
    "track.heading_abs_mean_deg",
    "track.heading_flip_rate",
    "track.moving_velocity_abs_mean_mps",
    "track.standing_speed_mean_mps",
    "track.acceleration_abs_mean_mps2",
    *(definition.name for definition in SIZE),
)

BANDED = tuple(definition for definition in OVERALL if definition.name in BANDED_NAMES)
"""Metrics of `OVERALL` that exist by range, class and view, too."""


def definitions() -> Iterator[Definition]:
    """Yield every `track` metric."""
    yield from OVERALL
    for definition, band in product(BANDED, BANDS):
        yield Definition(f"{definition.name}.{band}", definition.unit, definition.meaning)
