"""Construction of highway-env environments and restoration of what they change globally."""

import difflib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from luxloop import former_names
from luxloop.sim.source import TrafficError, TrafficInputError

SIMULATION_HZ = 25
POLICY_HZ = 12.5
"""A frame of the rig is one policy step of two simulation steps."""

_LONGEST_NAME = 60
"""Characters of an environment's name in error messages."""

_NO_OBSERVATION = {"observation": {"type": "AttributesObservation", "attributes": []}}
"""Empty observation: it is unused, and the environments' own are expensive or need attributes that IDM vehicles
lack."""

_TUNED_BY_INTERSECTIONS = ("DISTANCE_WANTED", "COMFORT_ACC_MAX", "COMFORT_ACC_MIN")
"""Class attributes that intersection-v* overwrites; they must not leak into the next run of this process."""

Tuning = list[tuple[type, dict[str, float]]]
"""Vehicle classes with values of their attributes."""


@contextmanager
def translated_errors(where: str, failure: type[TrafficError]) -> Iterator[None]:
    """Convert any exception of a third-party environment to a traffic error."""
    try:
        yield
    except TrafficError:
        raise
    except Exception as error:
        reason = f"{' '.join(str(error).split())}{former_names.remedy(error)}"
        raise failure(f"{where}: {type(error).__name__}: {reason}") from error


def environments() -> dict[str, str]:
    """Return the entry points of highway-env's environments by id."""
    import gymnasium
    import highway_env  # noqa: F401  registers its environments

    return {
        id: spec.entry_point
        for id, spec in sorted(gymnasium.registry.items())
        if isinstance(spec.entry_point, str) and spec.entry_point.startswith("highway_env.")
    }


def make(name: str, overrides: dict[str, Any]) -> Any:
    """Build an environment without gymnasium's wrappers, which would check, warn and truncate episodes.

    It is configured after construction, since some constructors take no configuration.

    Raises
    ------
    TrafficInputError
        highway-env registers no such environment, or the environment has no such key.
    """
    from gymnasium.envs.registration import load_env_creator

    known = environments()
    if name not in known:
        raise TrafficInputError(f'env = "{name[:_LONGEST_NAME]}" is unknown; {_did_you_mean(name, list(known))}')
    env: Any = load_env_creator(known[name])()
    for key in overrides:
        if key not in env.config:
            raise TrafficInputError(f"config.{key} is unknown to {name}; {_did_you_mean(key, sorted(env.config))}")
    env.configure(_NO_OBSERVATION | overrides | {"simulation_frequency": SIMULATION_HZ, "policy_frequency": POLICY_HZ})
    return env


def recorded_tuning(overrides: dict[str, Any]) -> Tuning:
    """Record the class attributes that an intersection would overwrite."""
    from highway_env.utils import class_from_path
    from highway_env.vehicle.behavior import IDMVehicle

    classes = [IDMVehicle]
    if "other_vehicles_type" in overrides:
        with translated_errors("config.other_vehicles_type", TrafficInputError):
            classes.append(class_from_path(overrides["other_vehicles_type"]))
    return [(cls, {name: getattr(cls, name) for name in _TUNED_BY_INTERSECTIONS}) for cls in classes]


def restore(tuning: Tuning) -> None:
    """Restore the class attributes of vehicles."""
    for vehicle_class, values in tuning:
        for name, value in values.items():
            setattr(vehicle_class, name, value)


def _did_you_mean(word: str, known: list[str]) -> str:
    close = difflib.get_close_matches(word, known)
    return f"did you mean {', '.join(close)}?" if close else f"known names are {', '.join(known)}"
