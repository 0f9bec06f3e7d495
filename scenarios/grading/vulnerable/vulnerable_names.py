"""Names, units and meanings of the metrics of people and riders."""

from collections.abc import Iterator

from luxloop.scenarios.grading.metric_definition import Definition
from luxloop.scenarios.grading.track_metric_names import RANGE_BANDS
from luxloop.sim.world import Kind

GROUPS = {"people": Kind.PEDESTRIAN, "riders": Kind.BICYCLE}
"""Class of the actors of each group. Motorcycles are vehicles."""

KIND_NAMES = {group: kind.name.lower() for group, kind in GROUPS.items()}
"""Name of the class of each group in the table `truth`."""

SCORES = {
    "hota": "higher order tracking accuracy, with similarity 1 - distance / match_distance_m",
    "deta": "detection accuracy of HOTA",
    "assa": "association accuracy of HOTA",
    "mota": "CLEAR multiple object tracking accuracy; a hit is within half of match_distance_m",
    "idf1": "F1 score of identities",
}
"""Scores with their meanings."""

COUNTS = {
    "id_switches": "changes of the track that hits one of them (CLEAR)",
    "fragments": "interruptions of a track (CLEAR)",
    "missed": "graded ones without a hit, summed over frames (CLEAR)",
    "false": "tracks of small road users that hit none, summed over frames (CLEAR)",
}
"""Counts of CLEAR with their meanings."""

OBSERVATIONS = "observations"
MISSED_SHARE = "missed_share"
CALLED_VEHICLE = "called_vehicle_share"


def definitions() -> Iterator[Definition]:
    """Yield every metric of people and riders."""
    for group in GROUPS:
        yield Definition(f"{group}.{OBSERVATIONS}", "count", f"graded {group}, summed over frames")
        for name, meaning in SCORES.items():
            yield Definition(f"{group}.{name}", "1", f"{group}: {meaning}")
        for name, meaning in COUNTS.items():
            yield Definition(f"{group}.{name}", "count", f"{group}: {meaning}")
        yield Definition(f"{group}.{MISSED_SHARE}", "1", f"{group} without a hit over all, both summed over frames")
        for band in RANGE_BANDS:
            yield Definition(f"{group}.{MISSED_SHARE}.by_range.{band}", "1", "the same of a band of the range [m]")
        yield Definition(
            f"{group}.{CALLED_VEHICLE}", "1", f"{group} followed by a track of a vehicle, over all of them"
        )
        yield Definition(f"{group}.position_abs_mean_m", "m", f"{group}: mean distance of the centres of hits")
        yield Definition(f"{group}.velocity_abs_mean_mps", "m/s", f"{group}: mean norm of the velocity error of hits")
        yield Definition(f"{group}.speed_abs_mean_mps", "m/s", f"{group}: mean absolute error of the speed of hits")
        yield Definition(
            f"{group}.time_to_confirm_s", "s", f"{group}: time from the first graded frame to the first hit, median"
        )
        yield Definition(f"{group}.never_confirmed", "1", f"share of graded {group} that no track ever hits")
