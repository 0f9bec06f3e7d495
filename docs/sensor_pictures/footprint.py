"""Hits of one unit's beams on the rear of a car: rays from behind, and points from the side."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from sensor_pictures.stage import (
    LUX,
    PART_COLORS,
    Cast,
    Floats,
    Scene,
    cast,
    label,
    one_unit,
    only_beam,
    rays_of,
    save,
    scene,
    sheet,
)

from luxloop.sensor_model.rig.unit import Fan, UnitModel
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sim.scripted.script import ScriptedActor

DISTANCE_M = 20.0
"""Distance from the unit to the rear of the car."""
FOOTPRINT = (9, 3)
CAR_LENGTH_M = 4.7
WINDOW = (-1.25, 1.25, -0.05, 1.6)
"""Limits of the picture in the plane at that distance: y and z [m]."""
PIXELS = 240


def draw() -> None:
    """Write the picture."""
    where = scene(ScriptedActor(x_m=DISTANCE_M + CAR_LENGTH_M / 2, y_m=0.0, reflectivity=0.4))
    figure, panels = sheet(1, 2, 11.0, 4.4)
    _photograph(panels[0, 0], where)
    for layer in range(4):
        for azimuth in _azimuths_deg(layer):
            beam = only_beam(azimuth, layer)
            rays = cast(where, one_unit(rays_of(beam, FOOTPRINT)), SensorConfig(footprint=(1, 1)))
            whole = cast(where, one_unit(beam))
            _from_behind(panels[0, 0], beam, rays)
            _from_the_side(panels[0, 1], layer, rays, whole)
    _finish(panels[0, 0], panels[0, 1])
    save(figure, "footprint")


def _azimuths_deg(layer: int) -> Floats:
    """Return the azimuths of a layer of the LUX over the width of the car."""
    fan = next(fan for fan in LUX.fans if layer in fan.layers)
    azimuths: Floats = fan.start_deg - fan.step_deg * np.arange(fan.count)
    return azimuths[np.abs(azimuths) < 3.3]


def _photograph(axes: Axes, where: Scene) -> None:
    """Draw the car as seen by a unit of many fine beams; brightness is returned power."""
    right, left, bottom, top = WINDOW
    half = np.rad2deg(np.arctan(left / DISTANCE_M))
    elevation = np.rad2deg(np.arctan((np.linspace(bottom, top, PIXELS) - 0.55) / DISTANCE_M))
    full = (100.0,) * len(LUX.gain_azimuth_deg)
    fan = Fan(tuple(range(PIXELS)), start_deg=half, stop_deg=-half, step_deg=2 * half / 400, gain_percent=full)
    camera = rays_of(only_beam(0.0, 0), (1, 1))
    camera = UnitModel(
        **{
            **{name: getattr(camera, name) for name in camera.__slots__},
            "layer_elevation_deg": tuple(elevation),
            "layer_bias_m": (0.0,) * PIXELS,
            "layer_pulse_bias_m": (0.0,) * PIXELS,
            "fans": (fan,),
        }
    )
    seen = cast(where, one_unit(camera), SensorConfig(footprint=(1, 1)))
    first = np.diff(seen.echoes.beam, prepend=-1) > 0
    beam = seen.echoes.beam[first]
    image = np.full(len(seen.beams), np.nan)
    image[beam] = np.where(
        seen.echoes.target[first] >= 0, seen.echoes.power[first] * seen.echoes.range[first] ** 2, np.nan
    )
    axes.imshow(
        np.sqrt(image.reshape(PIXELS, -1)),
        origin="lower",
        extent=(left, right, bottom, top),
        cmap="Greys_r",
        vmin=-0.2,
        vmax=0.75,
        aspect="equal",
    )


def _from_behind(axes: Axes, beam: UnitModel, rays: Cast) -> None:
    """Draw the footprint of a beam, and its rays in the plane of the car's rear."""
    (fan,) = beam.fans
    y, z = _place(fan.start_deg, beam.layer_elevation_deg[fan.layers[0]])
    width, height = DISTANCE_M * np.deg2rad([beam.beam_width_deg, beam.beam_height_deg])
    axes.add_patch(Rectangle((y - width / 2, z - height / 2), width, height, fill=False, color="0.85", linewidth=0.5))
    first = np.diff(rays.echoes.beam, prepend=-1) > 0
    azimuth, elevation = np.rad2deg([rays.beams.azimuth, rays.beams.elevation])
    y, z = _place(azimuth[rays.echoes.beam[first]], elevation[rays.echoes.beam[first]])
    axes.scatter(y, z, s=2.5, c=[PART_COLORS[part] for part in rays.part[first]], zorder=3)


def _place(azimuth_deg: Floats | float, elevation_deg: Floats | float) -> tuple[Floats, Floats]:
    """Return the intersection of a direction and the plane of the car's rear: y and z [m]."""
    azimuth, elevation = np.deg2rad(azimuth_deg), np.deg2rad(elevation_deg)
    return DISTANCE_M * np.tan(azimuth), 0.55 + DISTANCE_M * np.tan(elevation) / np.cos(azimuth)


def _from_the_side(axes: Axes, layer: int, rays: Cast, whole: Cast) -> None:
    """Draw the ends of the rays, and the points of the beam."""
    x, _, z = rays.points_ego.T
    axes.scatter(x, z, s=4, c=[PART_COLORS[part] for part in rays.part], zorder=2)
    x, _, z = whole.points_ego.T
    axes.scatter(x, z, s=22, marker="x", color="black", linewidths=0.8, zorder=3)
    axes.plot(
        [0.0, 40.0],
        0.55 + np.tan(np.deg2rad(LUX.layer_elevation_deg[layer])) * np.array([0.0, 40.0]),
        color="0.85",
        linewidth=0.6,
        zorder=0,
    )


def _finish(behind: Axes, side: Axes) -> None:
    behind.set(xlim=(WINDOW[1], WINDOW[0]), ylim=WINDOW[2:])
    label(
        behind,
        f"Rays of all beams on a car's rear, {DISTANCE_M:.0f} m away ({FOOTPRINT[0]} x {FOOTPRINT[1]} a beam)",
        "y left [m]",
        "z [m]",
    )
    for part, color in PART_COLORS.items():
        if part.name in ("GROUND", "BODY", "GREENHOUSE", "INTERIOR", "MIRROR", "WHEEL"):
            name = {"GREENHOUSE": "glass"}.get(part.name, part.name.lower())
            side.scatter([], [], s=12, color=color, label=f"ray ends on: {name}")
    side.scatter([], [], s=22, marker="x", color="black", linewidths=0.8, label="point of a beam")
    side.set(xlim=(19.5, 24.0), ylim=WINDOW[2:])
    side.legend(fontsize=7.5, loc="upper left", ncols=2)
    label(side, "The same from the side", "x from the unit [m]", "z [m]")
