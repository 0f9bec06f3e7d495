"""Figures of the paper, measured on its own recordings with hand-labelled truth, for comparison.

"Low-cost LIDAR based Vehicle Pose Estimation and Tracking", tables I to IV.
"""

DATASET = {
    "vehicles": 60,
    "observations": 5353,
    "frames": 1368,
    "observations_per_vehicle": 89,
    "observations_per_frame": 4,
}
"""Table I without the views. A "tracker" of the table is a vehicle tracked from its first to its last appearance."""

VIEWS = {"l_shape": 5037, "side": 115, "rear": 201}
"""Table I: observations by view of the vehicle."""

HEADING_DEG = {
    "area": (0.6483, 14.7989),
    "closeness": (0.0069, 3.6467),
    "variance": (-0.1517, 2.1869),
    "tlinkage": (0.3586, 2.3204),
    "best": (-0.223, None),
}
"""Table II: mean and STD of the heading error by method [deg]. The last STD is printed as -0.248, which is invalid."""

HEADING_ABS_DEG = {
    "area": (12.3310, 8.1437),
    "closeness": (2.0069, 3.0402),
    "variance": (1.4759, 1.6162),
    "tlinkage": (1.5586, 1.7515),
    "best": (1.3517, 1.2147),
}
"""Table II: mean and STD of the absolute heading error by method [deg]."""

WITHIN = {
    "variance": (0.607, 0.834, 0.910, 0.959, 0.972),
    "best": (0.600, 0.869, 0.965, 0.965, 0.993),
}
"""Table III: share of absolute heading errors of at most 1, 2, 3, 4 and 5 degrees."""

ZERO = {"variance": 0.221, "best": 0.234}
"""Table III: share of errors "= 0". A continuous error is never 0: headings were rounded, apparently to whole degrees.
Errors with a Laplace distribution of the mean of table II (variance), rounded, give 29, 64, 82, 91, 95 and 98 % in the
columns of table III, where the paper has 22, 61, 83, 91, 96 and 97 %; without rounding 0, 49, 74, 87, 93 and 97 %."""

POSITION_ABS_M = {
    ("single", "standing"): (0.1263, 0.0602, 0.1428, 0.0571),
    ("MMA", "standing"): (0.1239, 0.0570, 0.1376, 0.0544),
    ("single", "moving"): (0.2449, 0.1725, 0.1918, 0.1188),
    ("MMA", "moving"): (0.2384, 0.1397, 0.1626, 0.1201),
}
"""Table IV: x mean, x STD, y mean, y STD of the absolute position error by method and targets [m]."""
