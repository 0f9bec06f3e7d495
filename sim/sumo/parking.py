"""Parked cars on SUMO's parking areas, which are empty in SUMO until one of its vehicles stops there."""

import math
import re
import xml.etree.ElementTree as ET
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from luxloop import elementary
from luxloop.sim.sumo.input_checks import input_files, is_left_hand, text_of
from luxloop.sim.sumo.parking_places import Place, places_of
from luxloop.sim.world import Kind

DEFAULT_CAR = (5.0, 1.8, 1.5)
"""[m] Length, width, height of a car of SUMO's default type."""
SHORTEST, NARROWEST = 3.0, 1.4
"""[m] Smaller places are not for cars, and stay empty."""

_STOP_TARGET = re.compile(r"""parkingArea\s*=\s*["']([^"']+)|<parkingAreaReroute\s[^>]*?id\s*=\s*["']([^"']+)""")


@dataclass(frozen=True, slots=True)
class ParkedCar:
    """A car parked for the whole run."""

    name: str
    """Name of the parking area, and number of the place in it."""
    pose: tuple[float, float, float]
    """Box centre x [m], y [m], yaw [rad], in the net's coordinates."""
    size: tuple[float, float, float]
    """Length, width, height [m]."""
    kind: Kind


def parked_cars(command: Sequence[str], lanes: Any, fill: float, seed: int) -> list[ParkedCar]:
    """Return the cars on a random share of all parking places beside the road.

    Areas on the road stay empty, since SUMO's traffic would drive through the cars. So do areas that are targets of a
    stop or a rerouter.

    Parameters
    ----------
    command
        SUMO's command line, by `luxloop.sim.sumo.input_checks.sumo_command`. Its route and additional files are read.
    lanes
        libsumo's domain of lanes.
    fill
        Share of occupied places, 0 to 1.
    seed
        Seed of the run. The draw of each place is keyed by its name.
    """
    if not fill:
        return []
    texts = [text_of(path) for path in input_files(command)]
    areas = [area for text in texts if "<parkingArea" in text for area in ET.fromstring(text).iter("parkingArea")]
    busy = {name for text in texts for names in _STOP_TARGET.findall(text) for name in names}
    left_hand = is_left_hand(command)
    places = [place for area in areas if area.get("id") not in busy for place in places_of(area, lanes, left_hand)]
    return [_car(place) for place in places if _fits_a_car(place) and _draw(place, seed) < fill]


def _fits_a_car(place: Place) -> bool:
    return place.length >= SHORTEST and place.width >= NARROWEST


def _draw(place: Place, seed: int) -> float:
    """Draw a place's random number, 0 to 1, by (seed, name); by another key than its car's other draws."""
    key = np.array([seed % 2**64, zlib.crc32(place.name.encode())], dtype=np.uint64)
    return float(np.random.Generator(np.random.Philox(key=key, counter=[0, 0, 0, 3])).random())


def _car(place: Place) -> ParkedCar:
    size = (min(DEFAULT_CAR[0], place.length), min(DEFAULT_CAR[1], place.width), DEFAULT_CAR[2])
    x = place.front[0] - size[0] / 2 * elementary.cos(place.yaw)
    y = place.front[1] - size[0] / 2 * elementary.sin(place.yaw)
    return ParkedCar(place.name, (x, y, math.remainder(place.yaw, 2 * math.pi)), size, Kind.CAR)
