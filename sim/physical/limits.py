"""What vehicles and their drivers can do."""

import math

HIGHEST_ACCELERATION = 6.0
"""[m/s^2] Along the body: a motorcycle that starts."""
GRIP = 9.5
"""[m/s^2] Of the tyres on a dry road, along and across together (Kamm's circle): what a curve takes, a brake lacks."""
JERK = 30.0
"""[m/s^3] of the acceleration along the body."""
LATERAL_ACCELERATION = 5.4
"""[m/s^2] Speed x yaw rate; most drivers stay below 4, and tyres end near 9."""
LATERAL_JERK = 20.0
"""[m/s^3] of the rear axle, and of what the box centre's swing adds."""
SWING = 3.0
"""[m/s^2] Acceleration of the box centre across the body by yaw acceleration alone."""
SWING_ABOVE = 0.4
"""[m/s^2] by which it may, added to speed x yaw rate, exceed that one's limit."""
YAW_RATE_ON_WHEELS, YAW_RATE_ON_FOOT = 1.1, 3.0
"""[rad/s]"""
STEERING = math.radians(70.0)
"""[rad] Greatest angle between the way of a body's front and its heading; at the front wheels it is smaller."""
STANDING = 0.02
"""[m/s] Slower than this is standing."""

SETTLING_S = 0.25
"""[s] in which an error of the speed decays."""
STEERING_S = 0.1
"""[s] in which an error of the yaw rate decays."""
AHEAD_S, BEHIND_S = 0.3, 3.0
"""[s] Who is ahead of or behind the path's time steers for where it will be or was then, up to these."""
LAG_STEP_S = 0.1
"""[s] by which that time may change in a step; paths that turn back have several places that are as near."""
SLOW = 1.0
"""[m/s] Slower paths tell little by their direction."""
CATCH_UP = 1.2
"""[1/s] Speed per metre behind the path."""
CATCH_UP_SHARE, CATCH_UP_LEAST = 0.25, 2.0
"""[1], [m/s] Who is behind goes faster by at most this share of the path's speed, or this."""
AIM_M, AIM_S, AIM_RAD = 3.0, 0.5, 0.5
"""[m], [s], [rad] Who is beside the path steers for a point on it so far ahead, but by no more than this angle."""
CREEP = 0.3
"""[m/s] Who would close a gap to a standing path slower than this stays where it is."""
STEP_S = 0.04
"""[s] Longest step of the integration."""

JUMP_SPEED = 7.0
"""[m/s] sideways, from which a step across the lane is a jump: no steering does that, and SUMO's own modes with a
lateral resolution or a duration of lane changes stay below half of it."""
CORNER = 0.4
"""A corner of a lane's polyline turns the way ahead sideways, too: up to this share of it is no jump."""
JUMP_LONGEST = 6.0
"""[m] sideways; what moves farther in one step did not change lanes."""
LEAST_STEP = 0.005
"""[m] A shorter step does not tell a course."""
SLOW_CHANGE = 4.0
"""[m/s] Slower bodies take longer to change lanes, as they cover the same way along the road; who stands, waits."""
