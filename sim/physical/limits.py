"""Limits of vehicle dynamics and driver behaviour, and parameters of the path-following controller."""

import math

ACCELERATION_MAX = 6.0
"""[m/s^2] Longitudinal: a motorcycle that accelerates from standstill."""
GRIP = 9.5
"""[m/s^2] Tyre grip on a dry road, longitudinal and lateral combined (Kamm's circle)."""
JERK = 30.0
"""[m/s^3] Derivative of the longitudinal acceleration."""
LATERAL_ACCELERATION = 5.4
"""[m/s^2] Speed x yaw rate. Most drivers stay below 4; tyres reach about 9."""
LATERAL_JERK = 20.0
"""[m/s^3] Lateral jerk of the rear axle, and of the term that yaw acceleration adds at the box centre."""
SWING = 3.0
"""[m/s^2] Lateral acceleration of the box centre due to yaw acceleration."""
SWING_ABOVE = 0.4
"""[m/s^2] Margin by which the swing, added to speed x yaw rate, may exceed `LATERAL_ACCELERATION`."""
YAW_RATE_ON_WHEELS, YAW_RATE_ON_FOOT = 1.1, 3.0
"""[rad/s] Maximum yaw rate of vehicles and of pedestrians."""
STEERING = math.radians(70.0)
"""[rad] Maximum angle between a body's heading and the velocity of its front; the front-wheel angle is smaller."""
STANDING = 0.02
"""[m/s] Slower bodies count as standing."""

SETTLING_S = 0.25
"""[s] Time constant of the speed controller."""
STEERING_S = 0.1
"""[s] Time constant of the yaw rate controller."""
AHEAD_S, BEHIND_S = 0.3, 3.0
"""[s] Limits of the time lag: a body that is ahead of or behind its path aims at the path's later or earlier point."""
LAG_STEP_S = 0.1
"""[s] Maximum change of the lag per step. It keeps the match unique on paths that turn back on themselves."""
SLOW = 1.0
"""[m/s] The direction of slower paths is unreliable."""
CATCH_UP = 1.2
"""[1/s] Gain: additional speed per metre behind the path."""
CATCH_UP_SHARE, CATCH_UP_LEAST = 0.25, 2.0
"""[1], [m/s] A body behind its path exceeds the path's speed by at most this share or this speed."""
AIM_M, AIM_S, AIM_RAD = 3.0, 0.5, 0.5
"""[m], [s], [rad] A laterally displaced body steers for a point this far ahead on the path, within this angle."""
CREEP = 0.3
"""[m/s] A body does not close a gap to a standing path at less than this speed."""
STEP_S = 0.04
"""[s] Maximum step of the integration."""

JUMP_SPEED = 7.0
"""[m/s] Lateral speed above which a step counts as a jump. Steering cannot reach it; SUMO's gradual lane changes
(lateral resolution, duration of lane changes) stay below half of it."""
CORNER = 0.4
"""Corners of a lane's polyline add a lateral part to a step: up to this share of the longitudinal part is no jump."""
JUMP_LONGEST = 6.0
"""[m] Maximum lateral jump of a lane change; larger steps are not lane changes."""
SIDESTEP = 1.0
"""[m] A person whom the simulator moves at most this far aside in one step takes a step aside: smoothing alone leads to
about walking speed. A lane change at walking speed would take 12 s."""
LEAST_STEP = 0.005
"""[m] A shorter step does not define a course."""
SLOW_CHANGE = 4.0
"""[m/s] Slower bodies take longer to change lanes: the distance along the road is the same; standing bodies wait."""
