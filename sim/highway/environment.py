"""Environments of highway-env, built and taken down again."""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from sim.source import TrafficError, TrafficInputError

SIMULATION_HZ = 25
POLICY_HZ = 12.5
"""One frame of the rig is one policy step of two simulation steps."""

_LONGEST_NAME = 60
"""Of an environment, in complaints."""

_UNSEEN = {"observation": {"type": "AttributesObservation", "attributes": []}}
"""Nobody reads the observation; the environments' own are dear, or ask the ego for what an IDM vehicle lacks."""

_TUNED_BY_INTERSECTIONS = ("DISTANCE_WANTED", "COMFORT_ACC_MAX", "COMFORT_ACC_MIN")
"""intersection-v* overwrites these on the vehicle class; they must not leak into the next run of this process."""

Tuning = list[tuple[type, dict[str, float]]]
"""Attributes of vehicle classes and their values."""


@contextmanager
def foreign(where: str, failure: type[TrafficError]) -> Iterator[None]:
    """Turn whatever a third party's environment raises into our error."""
    try:
        yield
    except TrafficError:
        raise
    except Exception as error:
        raise failure(f"{where}: {type(error).__name__}: {' '.join(str(error).split())}") from error


def make(name: str, overrides: dict[str, Any]) -> Any:
    """Build an environment without gymnasium's wrappers, which would check, warn and truncate.

    It is configured afterwards: some constructors take no configuration.

    Raises
    ------
    TrafficInputError
        highway-env registers no such environment, or the environment has no such key.
    """
    import gymnasium
    import highway_env  # noqa: F401  registers its environments
    from gymnasium.envs.registration import load_env_creator

    known = {
        id: spec.entry_point
        for id, spec in sorted(gymnasium.registry.items())
        if isinstance(spec.entry_point, str) and spec.entry_point.startswith("highway_env.")
    }
    if name not in known:
        raise TrafficInputError(f'env = "{name[:_LONGEST_NAME]}" is unknown; {_did_you_mean(name, list(known))}')
    env: Any = load_env_creator(known[name])()
    for key in overrides:
        if key not in env.config:
            raise TrafficInputError(f"config.{key} is unknown to {name}; {_did_you_mean(key, sorted(env.config))}")
    env.configure(_UNSEEN | overrides | {"simulation_frequency": SIMULATION_HZ, "policy_frequency": POLICY_HZ})
    return env


def tuning(overrides: dict[str, Any]) -> Tuning:
    """Note what an intersection would overwrite."""
    from highway_env.utils import class_from_path
    from highway_env.vehicle.behavior import IDMVehicle

    classes = [IDMVehicle]
    if "other_vehicles_type" in overrides:
        with foreign("config.other_vehicles_type", TrafficInputError):
            classes.append(class_from_path(overrides["other_vehicles_type"]))
    return [(cls, {name: getattr(cls, name) for name in _TUNED_BY_INTERSECTIONS}) for cls in classes]


def restore(noted: Tuning) -> None:
    """Put vehicle classes back as they were."""
    for vehicle_class, values in noted:
        for name, value in values.items():
            setattr(vehicle_class, name, value)


def _did_you_mean(word: str, known: list[str]) -> str:
    close = difflib.get_close_matches(word, known)
    return f"did you mean {', '.join(close)}?" if close else f"known are {', '.join(known)}"
