"""Recordings by SUMO: floating car data, as written with `--fcd-output`.

The files contain the middle of the front bumper and an angle clockwise from north in degrees. A recording contains the
box centre and yaw; the conversion needs the length.
"""

import math
import xml.etree.ElementTree as ET
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sim.input_files import NOT_XML, open_gz
from luxloop.sim.replay.recording import Recording, ReplayType, RoadUser, kind_and_size
from luxloop.sim.source import TrafficInputError

ROOT = "fcd-export"
DEFAULT_TYPE = {"vehicle": "DEFAULT_VEHTYPE", "person": "DEFAULT_PEDTYPE"}
SLOWEST = 1e-3
"""[m/s] Moving road users are faster; in degrees of longitude and latitude even 100 m/s is slower."""

UserKey = tuple[bool, str]
"""True for persons, whose ids may equal those of vehicles, and the id. Vehicles sort first."""


def open_xml(path: Path) -> BinaryIO:
    """Open an XML file, compressed by gzip or not."""
    return open_gz(path) if path.suffix == ".gz" else path.open("rb")


def read_fcd(path: Path, types: Mapping[str, ReplayType]) -> Recording:
    """Read an `.xml` or `.xml.gz`, with at most one time step as XML in memory.

    Parameters
    ----------
    path
        The file.
    types
        Kind and size by vehicle type, since the file contains only the name of the type.

    Raises
    ------
    TrafficInputError
        The file is invalid or incomplete.
    """
    number: dict[UserKey, int] = {}
    type_of: list[str] = []
    values = array("d")
    try:
        for time_s, body in _bodies(path):
            key = (body.tag == "person", body.get("id", ""))
            user = number.setdefault(key, len(number))
            if user == len(type_of):
                type_of.append(body.get("type", DEFAULT_TYPE[body.tag]))
            values.extend((user, time_s, *_place(body, time_s)))
    except NOT_XML as error:
        raise TrafficInputError(f"not a complete XML file: {error}") from error
    if not values:
        raise TrafficInputError("has no vehicle and no person")
    table = np.frombuffer(values).reshape(-1, 5)
    return _recording(table[:, 0].astype(np.int64), table[:, 1:], number, type_of, types)


def _recording(
    user: Ints, samples: Floats, number: dict[UserKey, int], type_of: list[str], types: Mapping[str, ReplayType]
) -> Recording:
    """Number road users by id; convert samples (S, 4) of time, front bumper and angle to poses."""
    time, front, yaw = samples[:, 0], samples[:, 1:3], np.radians(90.0 - samples[:, 3])
    _require_metres(user, time, front)
    body_of = {word: kind_and_size(word, types) for word in sorted(set(type_of))}
    length = np.array([body_of[word][1][0] for word in type_of])[user]
    centre = front - 0.5 * length[:, None] * np.column_stack([elementwise.cos(yaw), elementwise.sin(yaw)])
    order = sorted(number)
    rank = np.argsort([number[key] for key in order])
    users = [RoadUser(key[1], *body_of[type_of[number[key]]]) for key in order]
    return Recording(users, rank[user], time, np.column_stack([centre, yaw]))


def _bodies(path: Path) -> Iterator[tuple[float, ET.Element]]:
    """Yield time [s] and element of each road user, without containers and passengers."""
    with open_xml(path) as stream:
        for _, step in ET.iterparse(stream):
            if step.tag != "timestep":
                continue
            time = _time(step)
            vehicles = step.findall("vehicle")
            yield from ((time, vehicle) for vehicle in vehicles)
            if persons := step.findall("person"):
                # SUMO writes passengers with the pose of their vehicle; default output has no other mark.
                occupied = {(vehicle.get("x"), vehicle.get("y"), vehicle.get("angle")) for vehicle in vehicles}
                for person in persons:
                    if (person.get("x"), person.get("y"), person.get("angle")) not in occupied:
                        yield time, person
            step.clear()


def _time(step: ET.Element) -> float:
    try:
        return float(step.get("time", ""))
    except ValueError as error:
        raise TrafficInputError(
            f'timestep time = "{step.get("time", "")}" should be seconds; write it without human-readable-time'
        ) from error


def _place(body: ET.Element, time: float) -> tuple[float, float, float]:
    """Return x [m], y [m] and angle [deg] of a body."""
    values = []
    for attribute in ("x", "y", "angle"):
        text = body.get(attribute, "")
        try:
            values.append(float(text))
        except ValueError as error:
            raise TrafficInputError(
                f'{body.tag} "{body.get("id")}" at {time:g} s: {attribute} = "{text}"; '
                "write x, y, angle and type (fcd-output.attributes)"
            ) from error
        if not math.isfinite(values[-1]):
            raise TrafficInputError(
                f'{body.tag} "{body.get("id")}" at {time:g} s: {attribute} = "{text}" is not a finite number'
            )
    x, y, angle = values
    return x, y, angle


def _require_metres(user: Ints, time: Floats, place: Floats) -> None:
    """Raise if positions are longitudes and latitudes, which the file does not declare."""
    order = np.lexsort((time, user))
    step = np.diff(time[order])
    same = (np.diff(user[order]) == 0) & (step > 0)
    with np.errstate(over="ignore"):  # absurd positions are refused later, by the body's name
        speed = elementwise.hypot(*np.diff(place[order], axis=0).T)[same] / step[same]
    speed = speed[speed > 0]
    if len(speed) and np.median(speed) < SLOWEST:
        raise TrafficInputError("x and y are degrees, not metres; write it without fcd-output.geo")
