"""All limits of grading. They are printed with every result."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GradingConfig:
    """Limits of grading."""

    range_max_m: float = 50.0
    """Maximum distance from the ego's centre to the vehicle's [m]. Vehicles and false tracks beyond are not graded."""
    points_min: int = 10
    """Least number of scan points on a vehicle that is graded in a frame."""
    bent_deg: float = 5.0
    """Fits and poses of an articulated truck, bus or tram bent by a larger angle [deg] are not graded in that frame,
    because one rectangle does not describe it; its track must follow one of its sections, such as trailer or tractor.
    At 5 degrees, the smallest rectangle around a truck is 1.4 degrees off its trailer, as much as good fits."""
    memory_s: float = 3.0
    """Longest occlusion [s] that counts for `track.occlusion_survival`, also the longest time to the track before and
    after it."""
    hidden_fraction_max: float = 0.1
    """A vehicle is occluded in a gap of its grading if its visible fraction falls to this value or below."""
    match_iou_min: float = 0.1
    """Least bird's-eye overlap of a track and the actor that it follows. Low, because it only identifies the actor: a
    track of the rear of a long truck still follows the truck. HOTA and CLEAR grade the quality of the overlap."""
    hit_iou_min: float = 0.5
    """Least overlap of a hit of CLEAR and Identity (trackeval's default)."""
    owner_share_min: float = 0.5
    """A segment belongs to a vehicle if the vehicle's share of its points is larger than this."""
    part_share_min: float = 0.2
    """Least share of the points of a vehicle (or of a segment) for which a part of it counts."""
    gospa_cutoff_m: float = 2.0
    """Distance of the centres of a track and a vehicle [m] from which GOSPA counts a missed vehicle and a false track
    instead of an error: nuScenes' limit for errors of pairs (Caesar et al. 2020). A car's box at the limit of a hit is
    1.5 m off along its length."""
    located_position_m: float = 0.5
    """A confirmed track has located an actor if its centre is within this distance of the actor's [m]."""
    located_heading_deg: float = 5.0
    """It must also be within this angle of the actor's heading [deg], except for pedestrians."""
    nees_confidence: float = 0.95
    """Probability of the two-sided chi-square band for the position error of a consistent filter."""
    vulnerable_points_min: int = 6
    """Least number of scan points on a person or rider that is graded in a frame: more than 5, the limit of LEVEL_1
    labels of the Waymo Open Dataset (Sun et al. 2020). Two beams in three of the four layers, 0.25 degrees apart, hit a
    person of 0.5 m up to about 40 m."""
    vulnerable_range_max_m: float = 40.0
    """Maximum distance of people and riders from the ego's centre [m], as nuScenes' detection range of both classes."""
    match_distance_m: float = 2.0
    """Distance of the centres [m] at which a track is not on a person or rider any more, nuScenes' limit. The
    similarity falls linearly to 0 there, as trackeval's of points; a hit is within half of it: an end of a bicycle is
    0.9 m from its centre."""
    target: str = ""
    """Name of the actor that the metrics `emergence.*` describe, e.g. of one that drives out of an occlusion."""

    def __post_init__(self) -> None:
        for name in (
            "range_max_m",
            "bent_deg",
            "memory_s",
            "gospa_cutoff_m",
            "vulnerable_range_max_m",
            "match_distance_m",
            "located_position_m",
            "located_heading_deg",
        ):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} = {getattr(self, name)} must be positive")
        for name in ("points_min", "vulnerable_points_min"):
            if getattr(self, name) < 1:
                raise ValueError(
                    f"{name} = {getattr(self, name)} must be 1 or more: an actor without points is not graded"
                )
        for name in ("match_iou_min", "hit_iou_min", "nees_confidence", "part_share_min"):
            if not 0 < getattr(self, name) < 1:
                raise ValueError(f"{name} = {getattr(self, name)} must lie between 0 and 1")
        if not 0.5 <= self.owner_share_min < 1:
            raise ValueError(
                f"owner_share_min = {self.owner_share_min} must be 0.5 or more and below 1, "
                "or a segment could have two owners"
            )
        if not 0 <= self.hidden_fraction_max < 1:
            raise ValueError(f"hidden_fraction_max = {self.hidden_fraction_max} must be 0 or more and below 1")
