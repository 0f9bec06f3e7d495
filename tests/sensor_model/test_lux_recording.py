"""The simulated LUX beside one recorded scan of a real one, on targets 1.2 to 1.5 m away.

The figures of the recording are those of the message 0x2202 among the test data of sick_scan_xd (SICK AG). Print the
comparison with `pytest -s`.
"""

import numpy as np
import pytest
from support.real_data import real_file
from support.sensor_scenes import FOOTPRINT, one_unit_rig, wall, world

from luxloop.sensor_model.formats.lux_scan_message import decode
from luxloop.sensor_model.formats.lux_scan_points import scan_messages
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import FalseAlarms, NoiseConfig
from luxloop.sensor_model.rig.rig import SHIPPED, load_unit

RIG = one_unit_rig(load_unit("lux", SHIPPED), z=1.5)
FRAMES = 30
LEVEL_DEG = {0: 45.0, 1: 45.0, 2: 32.0, 3: 32.0}
"""Right of this the gain of a layer hardly changes."""
BEYOND_DEG = 25.0
"""The fragment ends here."""
REFLECTIVITY = 0.3
"""Of the target; not known, so that the mean width of the four layers is no evidence."""

RECORDED = {
    "first azimuth, lower pair [deg]": (50.0, 50.0),
    "first azimuth, upper pair [deg]": (34.75, 34.75),
    "step of a layer [deg]": (0.5, 0.5),
    "offset of the pairs [deg]": (0.25, 0.25),
    "sweep [deg/s]": (4490.0, 4510.0),
    "range noise [cm]": (1.2, 1.8),
    "range, layer 1 - 0 [cm]": (1.9 - 0.8, 1.9 + 0.8),  # twice the standard error of 50 pairs with 2.6 cm
    "range, layer 3 - 2 [cm]": (-0.7 - 1.3, -0.7 + 1.3),  # of 19 pairs with 2.8 cm
    "pulse width quantum [cm]": (4.0, 4.0),
    "pulse width, layer 0 [m]": (1.92 - 0.05, 1.92 + 0.05),
    "pulse width, layer 1 [m]": (2.08 - 0.05, 2.08 + 0.05),
    "pulse width, layer 2 [m]": (1.44 - 0.05, 1.44 + 0.05),
    "pulse width, layer 3 [m]": (1.60 - 0.05, 1.60 + 0.05),
    "pulse width, spread in a layer [cm]": (7.8, 12.3),
    "pulse width at 40 to 47 deg [m]": (2.01 - 0.05, 2.01 + 0.05),
    "pulse width at 48 to 50 deg [m]": (1.77 - 0.05, 1.77 + 0.05),
}
"""Range of each figure."""


def figures(message):
    """Return the figures of a scan left of `BEYOND_DEG`, by the same steps for real and simulated messages."""
    azimuth, layer = message.azimuth_ticks / 32, message.layer
    near = (azimuth >= BEYOND_DEG) & (message.echo == 0)
    at = {number: near & (layer == number) for number in range(4)}
    lower = at[0] | at[1]
    span = np.abs(message.header.start_ticks - message.header.end_ticks) / 32
    found = {
        "first azimuth, lower pair [deg]": azimuth[lower].max(),
        "first azimuth, upper pair [deg]": azimuth[at[2] | at[3]].max(),
        "step of a layer [deg]": np.median(-np.diff(azimuth[at[0]])),
        "offset of the pairs [deg]": (azimuth[at[2]][0] - azimuth[at[0]][0]) % 0.5,
        "sweep [deg/s]": span / message.duration_s,
        "range noise [cm]": np.mean([noise(message.range_cm[at[number]]) for number in range(4)]),
        "range, layer 1 - 0 [cm]": apart(message, azimuth, at[0], at[1]),
        "range, layer 3 - 2 [cm]": apart(message, azimuth, at[2], at[3]),
        "pulse width quantum [cm]": float(np.gcd.reduce(message.width_cm[near])),
        "pulse width, spread in a layer [cm]": np.mean(
            [spread(azimuth[at[number]], message.width_cm[at[number]], beyond) for number, beyond in LEVEL_DEG.items()]
        ),
        "pulse width at 40 to 47 deg [m]": message.width_cm[lower & (azimuth >= 40) & (azimuth <= 47)].mean() / 100,
        "pulse width at 48 to 50 deg [m]": message.width_cm[lower & (azimuth >= 48)].mean() / 100,
    }
    return found | {
        f"pulse width, layer {number} [m]": np.median(message.width_cm[at[number]]) / 100 for number in range(4)
    }


def spread(azimuth, width_cm, beyond_deg):
    """Return the standard deviation of widths about a line over azimuth, right of the layer's end."""
    level = azimuth < beyond_deg
    line = np.polyfit(azimuth[level], width_cm[level].astype(float), 1)
    return (width_cm[level] - np.polyval(line, azimuth[level])).std()


def noise(range_cm):
    """Return the robust standard deviation of ranges along a layer, by second differences, which a plane leaves 0."""
    return 1.4826 * np.median(np.abs(np.diff(range_cm.astype(float), 2))) / np.sqrt(6)


def apart(message, azimuth, first, second):
    """Return the mean range of one layer minus that of another at equal azimuths."""
    _, i, k = np.intersect1d(azimuth[first], azimuth[second], return_indices=True)
    return (message.range_cm[second][k].astype(float) - message.range_cm[first][i]).mean()


def arc(radius, low_deg, high_deg, step_deg=3.0, thickness=0.5):
    """Return the corners of a wall about the unit, of panels that face it."""
    angle = np.deg2rad(np.arange(low_deg, high_deg + step_deg, step_deg))
    inner, outer = ([(r * np.cos(a), r * np.sin(a)) for a in angle] for r in (radius, radius + thickness))
    return [*inner, *outer[::-1]]


@pytest.fixture(scope="module")
def simulated():
    """Figures of the simulated unit: means over scans."""
    obstacles = wall(*arc(1.35, 15.0, 60.0), reflectivity=REFLECTIVITY)
    lidar = Lidar(RIG, NoiseConfig(false_alarms=FalseAlarms(enabled=False)), FOOTPRINT, 1, obstacles)
    of_frames = []
    for index in range(FRAMES):
        (message,) = scan_messages(lidar.scan(world(index=index))[0], RIG, index)
        of_frames.append(figures(message))
    means = {name: np.mean([each[name] for each in of_frames]) for name in RECORDED}
    print("\n" + "\n".join(f"{name:34} recorded {low:8.2f} to {high:8.2f}   simulated {means[name]:8.2f}"
                           for name, (low, high) in RECORDED.items()))  # fmt: skip
    return means


@pytest.mark.parametrize("name", RECORDED)
def test_simulated_unit_agrees_with_the_recording(simulated, name):
    low, high = RECORDED[name]
    assert low - 1e-9 <= simulated[name] <= high + 1e-9


def test_recorded_figures_are_those_of_the_fragment():
    """Fails if the table above is not what the recording says."""
    found = figures(decode(real_file("lux/scan_0x2202.bin").read_bytes(), fragment=True))
    for name, (low, high) in RECORDED.items():
        assert low - 0.04 <= found[name] <= high + 0.04, name
