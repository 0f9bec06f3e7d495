"""Odometry drift: dead reckoning by wheel speeds and a gyroscope."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OdometryNoise:
    """Errors of the ego motion measured by odometry; they accumulate in the pose."""

    enabled: bool = True
    """If false, the pose is exact and the other keys have no effect."""
    speed_scale_sigma: float = 0.005
    """[1] Standard deviation of the relative error of distances, constant over a run: 1.6 mm of a tyre's 320 mm. Radii
    can be estimated to a millimetre with satellite positioning (Özkan, Lundquist and Gustafsson 2012, "A Bayesian
    Approach to Jointly Estimate Tire Radii and Vehicle Trajectory"); worn tyres are 5 mm smaller."""
    yaw_rate_sigma_dps: float = 0.02
    """[deg/s] Standard deviation of the gyroscope's bias after calibration at standstill, constant over a run;
    72 deg/h. Gyroscopes of rate grade, as for stability control, drift by 10 to 1000 deg/h (Norouzpour-Shirazi, IEEE
    Sensors 2013 tutorial)."""
    yaw_walk_sigma_deg: float = 0.02
    """[deg] Standard deviation of the yaw's random walk after one second; it grows with the square root of time. It is
    1.2 deg/sqrt(h); gyroscopes of rate grade have more than 0.5 (same tutorial)."""

    def __post_init__(self) -> None:
        limits = {"speed_scale_sigma": 0.1, "yaw_rate_sigma_dps": 2.0, "yaw_walk_sigma_deg": 2.0}
        for name, most in limits.items():
            if not 0.0 <= getattr(self, name) <= most:
                raise ValueError(f"{name} = {getattr(self, name)}: must be from 0 to {most:g}")
