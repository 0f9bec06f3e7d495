"""Settings of the tracks of small road users."""

from dataclasses import dataclass

from luxloop.tracker.bounds import require_within


@dataclass(frozen=True, slots=True)
class SmallConfig:
    """Tracks of people and bicycles: sizes, motion, and confirmation.

    A person has no visible shape at this resolution, and stands like a pole. Only motion distinguishes them, so a
    person is confirmed after a few steps, and one that never walks is not.
    """

    enabled: bool = True
    """Track small road users beside the vehicles. Off: as in the paper, which tracks vehicles only."""
    longer_max_m: float = 2.0
    """Maximum length of a bicycle with its rider [m]: nuScenes' labels are 1.7 by 0.6 m on average."""
    wider_max_m: float = 1.0
    """Maximum width of a rider or a person with swinging arms [m]; vehicles are wider."""
    position_std_m: float = 0.15
    """Standard deviation of the centre of the points [m]: legs and arms swing, and one side of a person of 0.3 to 0.5 m
    is visible."""
    acceleration_std_mps2: float = 0.7
    """Acceleration of people who walk: 0.68 on average (Teknomo 2002) [m/s^2]; cyclists start with 0.6 to 0.9
    (Parkin and Rotheram 2010)."""
    acceleration_time_s: float = 0.5
    """Its correlation time, a step at 2 steps a second [s]; the spectral density is 2 x 0.7^2 x 0.5 = 0.5 m^2/s^3."""
    initial_speed_std_mps: float = 2.5
    """Standard deviation of the first speed along an axis [m/s]: people walk at 1.34 (Weidmann 1993), and cyclists ride
    at 4 to 6."""
    gate: float = 13.8
    """Gate on the squared Mahalanobis distance of an observation: 99.9 % of chi-square with 2 degrees of freedom."""
    left_m: float = 0.8
    """Distance from the first place at which a track is confirmed [m]: more than the width of a person, so that another
    view of a pole or a trunk is no motion."""
    speed_min_mps: float = 0.5
    """Least speed at confirmation [m/s]; slow walkers do 0.7, two standard deviations below the mean."""
    straight_min: float = 0.7
    """Least distance from the first place, as a share of the way of the track's estimates: noise wanders."""
    confirm_hits: int = 8
    """Least number of observations for confirmation: a person walks `left_m` in 0.6 s, and parts of passing vehicles
    that look small are rarely visible for longer."""
    tentative_coast_s: float = 0.2
    """A tentative track is terminated if it was not seen for longer than this [s]."""
    gap_s: float = 0.25
    """A confirmed track stays confirmed through gaps up to this length [s] and coasts after it."""
    coast_s: float = 1.0
    """A confirmed track is terminated if it was not seen for longer than this [s]: a person's course is unknown to
    0.35 m after it."""
    size_gain: float = 0.1
    """Gain of the filter of the visible extents."""
    rider_speed_mps: float = 3.0
    """A small road user faster than this rides [m/s]: joggers run at 2.5 to 3."""
    vehicle_margin_m: float = 0.4
    """Points within this distance of a vehicle's box are a part of it [m]: mirrors, and errors of its size."""
    attached_m: float = 1.5
    """Points within this distance of a moving vehicle's box that keep its speed are a part of it [m]: long mirrors, and
    ends of a truck that its box does not cover yet."""
    attached_speed_mps: float = 1.0
    """Largest difference of the velocities of a vehicle and its part [m/s], and least speed of that vehicle."""
    whole_views_min: int = 3
    """Least number of views of both sides from end to end after which a vehicle's box that was never seen larger than a
    bicycle is a bicycle; a part of a vehicle behind others is truncated."""
    same_m: float = 1.0
    """A track of vehicle stages and a small one are of one object within this distance of their centres [m]."""

    def __post_init__(self) -> None:
        require_within(self, 1e-3, 1e3, "longer_max_m", "wider_max_m", "position_std_m", "acceleration_std_mps2")
        require_within(self, 1e-3, 1e3, "acceleration_time_s", "initial_speed_std_mps", "gate", "left_m", "same_m")
        require_within(self, 0.0, 1e3, "attached_m", "attached_speed_mps")
        require_within(self, 0.0, 1e3, "speed_min_mps", "tentative_coast_s", "gap_s", "coast_s")
        require_within(self, 0.0, 1e3, "rider_speed_mps", "vehicle_margin_m")
        require_within(self, 0.0, 1.0, "straight_min", "size_gain")
