"""Format `commonroad`: recorded traffic in CommonRoad XML, version 2020a, read by commonroad-io."""

import warnings
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from luxloop import elementary
from luxloop.arrays import Floats
from luxloop.sim.commonroad.commonroad_checks import require_plausible_numbers
from luxloop.sim.obstacles import Prism
from luxloop.sim.optional_packages import install_command
from luxloop.sim.replay.recording import Recording, ReplayType, RoadUser, kind_and_size
from luxloop.sim.source import TrafficInputError

TRAFFIC_ROOT = "commonRoad"
ROAD_USERS = {
    "priorityVehicle": ReplayType("van"),
    "parkedVehicle": ReplayType("car"),
    "taxi": ReplayType("car"),
    "unknown": ReplayType("car"),
    "train": ReplayType("bus"),
}
"""CommonRoad's types of road users whose names differ from those of kinds; static ones are actors, too."""
STREET_HEIGHT = {"building": 10.0, "pillar": 4.0, "constructionZone": 1.0, "roadBoundary": 0.81, "median_strip": 0.2}
"""[m] Heights of other types: estimates, since CommonRoad is flat."""
STREET_REFLECTIVITY = 0.3


def read_traffic(path: Path, types: Mapping[str, ReplayType]) -> Recording:
    """Read road users, named by obstacle id; planning problems have no trajectory and are ignored.

    Parameters
    ----------
    path
        The file.
    types
        Kind and height by CommonRoad type, in addition to `ROAD_USERS`; lengths and widths come from the file.

    Raises
    ------
    TrafficInputError
        commonroad-io is not installed, or cannot read the file, or a state is uncertain.
    """
    try:
        with warnings.catch_warnings():
            # raised by protobuf 3.20.2, which commonroad-io requires, on Python 3.12 and later
            warnings.simplefilter("ignore", DeprecationWarning)
            from commonroad.common.file_reader import CommonRoadFileReader
    except ImportError as error:
        remedy = install_command("commonroad")
        raise TrafficInputError(f"a CommonRoad file needs commonroad-io, which is not installed: {remedy}") from error
    require_plausible_numbers(path)
    try:
        with warnings.catch_warnings(), redirect_stderr(StringIO()), redirect_stdout(StringIO()):
            warnings.simplefilter("ignore")  # on names of scenarios and countries, also printed
            scenario, _ = CommonRoadFileReader(path).open()
        return _recording(scenario, types)
    except TrafficInputError:
        raise
    except Exception as error:  # the reader and its records raise many types, including bare Exception
        reason = " ".join([type(error).__name__, *str(error).split()])
        raise TrafficInputError(f"commonroad-io cannot read it: {reason}") from error


def _recording(scenario: Any, types: Mapping[str, ReplayType]) -> Recording:
    """Convert a scenario of commonroad-io."""
    moving = [(obstacle, _states(obstacle)) for obstacle in scenario.dynamic_obstacles]
    steps = [state.time_step for _, states in moving for state in states]
    if not steps:
        raise TrafficInputError("has no dynamic obstacle with a trajectory")
    standing = [one for one in scenario.static_obstacles if _word(one) not in STREET_HEIGHT]
    always = range(min(steps), max(steps) + 1)
    tracks = [_track(obstacle, [(state.time_step, state) for state in states]) for obstacle, states in moving]
    tracks += [_standing(obstacle, always) for obstacle in standing]
    samples = np.concatenate(tracks)
    return Recording(
        users=[_road_user(obstacle, types) for obstacle in [*(one for one, _ in moving), *standing]],
        user=np.repeat(np.arange(len(tracks)), [len(track) for track in tracks]),
        time=samples[:, 0] * scenario.dt,
        pose=samples[:, 1:],
        street=_street(scenario),
    )


def _word(obstacle: Any) -> str:
    return str(obstacle.obstacle_type.value)


def _states(obstacle: Any) -> list[Any]:
    later = getattr(obstacle.prediction, "trajectory", None)
    return [obstacle.initial_state, *(later.state_list if later else [])]


def _track(obstacle: Any, states: list[tuple[int, Any]]) -> Floats:
    """Return time step and box centre (K, 4): x [m], y [m], yaw [rad]."""
    rear, right, front, left = _box(obstacle)
    forward, aside = (rear + front) / 2, (right + left) / 2
    rows = []
    for step, state in states:
        if state.is_uncertain_position or state.is_uncertain_orientation:
            raise TrafficInputError(
                f"obstacle {obstacle.obstacle_id} at time step {step}: position and orientation should be exact"
            )
        (x, y), yaw = state.position, float(state.orientation)
        cos, sin = elementary.cos(yaw), elementary.sin(yaw)
        rows.append((step, x + forward * cos - aside * sin, y + forward * sin + aside * cos, yaw))
    return np.array(rows, dtype=np.float64)


def _standing(obstacle: Any, steps: range) -> Floats:
    """Return the same for an obstacle that stands during all these time steps."""
    place = np.tile(_track(obstacle, [(0, obstacle.initial_state)]), (len(steps), 1))
    place[:, 0] = steps
    return place


def _box(obstacle: Any) -> tuple[float, float, float, float]:
    """Return the bounds of an obstacle relative to its position in the file: rear, right, front, left [m]."""
    from commonroad.scenario.state import CustomState

    straight = CustomState(time_step=0, position=np.zeros(2), orientation=0.0, hitch_angle=0.0)
    rear, right, front, left = _area(obstacle.obstacle_shape.compute_occupancy_for_state(straight)).bounds
    return rear, right, front, left


def _area(occupancy: Any) -> Any:
    """Return the occupied area as a shapely object; commonroad-io 2026.1 gives circles half their radius."""
    radius = getattr(occupancy, "radius", None)
    return occupancy.circle_center.buffer(radius) if radius else occupancy.shapely_object


def _road_user(obstacle: Any, types: Mapping[str, ReplayType]) -> RoadUser:
    word = "trailer-truck" if hasattr(obstacle.obstacle_shape, "trailer_dims") else _word(obstacle)
    kind, default_size = kind_and_size(word, {**ROAD_USERS, **types})
    rear, right, front, left = _box(obstacle)
    return RoadUser(str(obstacle.obstacle_id), kind, (front - rear, left - right, default_size[2]))


def _street(scenario: Any) -> list[Prism]:
    """Return the obstacles that are not road users."""
    standing = [
        (one, _area(one.obstacle_shape.compute_occupancy_for_state(one.initial_state)))
        for one in scenario.static_obstacles
        if _word(one) in STREET_HEIGHT
    ]
    standing += [(one, _area(one.occupancy)) for one in scenario.environment_obstacle]
    return [
        Prism(np.array(outline.exterior.coords)[:-1], 0.0, _street_height(obstacle), STREET_REFLECTIVITY)
        for obstacle, area in standing
        for outline in getattr(area, "geoms", [area])
    ]


def _street_height(obstacle: Any) -> float:
    return STREET_HEIGHT.get(_word(obstacle), STREET_HEIGHT["building"])
