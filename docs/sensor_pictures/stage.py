"""Shared tools of the pictures: small scenes, special units, colours, outlines."""

from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from luxloop.sensor_model.bodies.scene import Bodies, BodyFactory
from luxloop.sensor_model.bodies.walls import walls_of
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.raycaster import Echoes, Raycaster
from luxloop.sensor_model.rig.beams import BeamTable, beam_table
from luxloop.sensor_model.rig.rig import SHIPPED, Mount, Rig, load_rig, load_unit
from luxloop.sensor_model.rig.unit import UnitModel
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.sensor_config import SensorConfig
from luxloop.sensor_model.truth import Cause, Part, ScanTruth
from luxloop.sim.scripted.script import ScriptedActor, ScriptedEgo, ScriptedObstacle
from luxloop.sim.scripted.scripted_source import ScriptedSource, ScriptedTraffic
from luxloop.sim.world import Obstacles, WorldFrame
from luxloop.tracker.scan import Scan

Floats = npt.NDArray[np.float64]

FOLDER = Path(__file__).parents[1] / "pictures"
LUX = load_unit("lux", SHIPPED)
SRX = load_rig("srx_six_lux", SHIPPED)

LOWER, UPPER = "tab:blue", "tab:orange"
PART_COLORS = {
    Part.GROUND: "tan",
    Part.OBSTACLE: "0.35",
    Part.BODY: "tab:blue",
    Part.GREENHOUSE: "darkturquoise",
    Part.INTERIOR: "tab:orange",
    Part.MIRROR: "magenta",
    Part.WHEEL: "black",
}
CAUSE_COLORS = {
    Cause.CLEAN: "0.55",
    Cause.MIRROR: "magenta",
    Cause.LAYER_OVERLAP: "darkorange",
    Cause.RANGE_OUTLIER: "tab:green",
    Cause.GHOST: "tab:red",
    Cause.DOUBLED: "tab:blue",
    Cause.FALSE_ALARM: "tab:olive",
    Cause.RAIN: "royalblue",
    Cause.SPRAY: "tab:cyan",
    Cause.SNOW: "lightskyblue",
    Cause.FOG: "silver",
}
_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)])


@dataclass(frozen=True)
class Scene:
    """Instant of a scripted world."""

    frame: WorldFrame
    obstacles: Obstacles


def scene(
    *actors: ScriptedActor, ego: ScriptedEgo | None = None, street: tuple[ScriptedObstacle, ...] = (), frame: int = 0
) -> Scene:
    """Simulate a script up to a frame; in the first frame all actors are at their scripted poses."""
    traffic = ScriptedTraffic(
        ego=ego or ScriptedEgo(), actor=list(actors), obstacle=list(street), jitter_m=0.0, jitter_deg=0.0
    )
    source = ScriptedSource(traffic, Path(), range_m=200.0)
    obstacles = source.reset(seed=1)
    for _ in range(frame):
        source.step()
    return Scene(source.step(), obstacles)


def noise(*kinds: str, **strengths: object) -> NoiseConfig:
    """Return only these kinds of noise, optionally with other strengths (`mirror=MirrorNoise(...)`)."""
    config = NoiseConfig()
    switched = {kind: replace(getattr(config, kind), enabled=kind in kinds) for kind in KINDS}
    return replace(config, **{**switched, **strengths})


BODIES_AS_THEY_ARE = noise("mirror", "layer_overlap")
"""No losses and no errors; bodies with mirrors, windows and decks."""


def sense(
    where: Scene, config: NoiseConfig = BODIES_AS_THEY_ARE, sensor: SensorConfig | None = None, rig: Rig = SRX,
    seed: int = 1,
) -> tuple[Scan, ScanTruth]:  # fmt: skip
    """Return a scan of a scene and its truth."""
    return Lidar(rig, config, sensor or SensorConfig(), seed, where.obstacles).scan(where.frame)


def one_unit(model: UnitModel, z_m: float = 0.55, pitch_deg: float = 0.0, x_m: float = 0.0) -> Rig:
    """Return a rig of one forward unit above the ego frame's x axis."""
    return Rig(0.0, (Mount("only", model, x_m, 0.0, z_m, yaw_deg=0.0, pitch_deg=pitch_deg, roll_deg=0.0),))


def only_beam(azimuth_deg: float, layer: int) -> UnitModel:
    """Return a LUX with a single beam."""
    fan = next(fan for fan in LUX.fans if layer in fan.layers)
    return replace(LUX, fans=(replace(fan, layers=(layer,), start_deg=azimuth_deg, stop_deg=azimuth_deg),))


def rays_of(beam: UnitModel, footprint: tuple[int, int]) -> UnitModel:
    """Return a unit with the rays of a single beam as separate beams, which report echoes of any power."""
    (fan,) = beam.fans
    rows, columns = footprint
    rise = beam.beam_height_deg * ((np.arange(rows) + 0.5) / rows - 0.5)
    step = beam.beam_width_deg / columns
    left = fan.start_deg + 0.5 * (columns - 1) * step
    layers = tuple(range(rows))
    return replace(
        beam,
        reference_reflectivity=1e-12,
        pulse_length_m=1e-6,
        pulse_growth_m_per_db=0.0,
        echo_separation_m=0.0,
        layer_elevation_deg=tuple(beam.layer_elevation_deg[fan.layers[0]] + rise),
        layer_bias_m=(0.0,) * rows,
        layer_pulse_bias_m=(0.0,) * rows,
        fans=(replace(fan, layers=layers, start_deg=left, stop_deg=left - (columns - 1) * step, step_deg=step),),
    )


@dataclass(frozen=True, eq=False)
class Cast:
    """Result and inputs of a ray cast."""

    beams: BeamTable
    bodies: Bodies
    echoes: Echoes

    @property
    def part(self) -> npt.NDArray[np.uint8]:
        """(N,) `Part` of each echo."""
        part = np.where(self.echoes.target == -2, Part.GROUND, Part.OBSTACLE).astype(np.uint8)
        on_actor = self.echoes.target >= 0
        part[on_actor] = self.bodies.plane_part[self.echoes.surface[on_actor]]
        return part

    @property
    def points_ego(self) -> Floats:
        """(N, 3) echoes on the centres of their beams [m]."""
        origin = self.beams.units.origin_ego[self.beams.unit[self.echoes.beam]]
        return origin + self.echoes.range[:, None] * self.beams.direction_ego[self.echoes.beam]


def cast(
    where: Scene, rig: Rig, sensor: SensorConfig | None = None, threshold: Floats | None = None, extinction: float = 0.0
) -> Cast:
    """Cast a rig's beams into a scene, without noise; by default with the thresholds of the units."""
    sensor = sensor or SensorConfig()
    beams, ego = beam_table(rig), where.frame.ego
    bodies = BodyFactory(mirrors=True, plain=False, glass=sensor.glass, seed=None).place(where.frame)
    context = ScanContext(
        frame_index=where.frame.index,
        origin_ego=beams.units.origin_ego,
        R_ego_unit=beams.units.R_ego_unit,
        time_jitter=np.zeros(len(beams.units)),
        ego_velocity=np.zeros(2),
        ego_acceleration=np.zeros(2),
        ego_yaw_rate=0.0,
        threshold=beams.units.threshold[beams.unit] if threshold is None else threshold,
        extinction=extinction,
    )
    walls = walls_of(where.obstacles).seen_from(ego.pose_world)
    return Cast(beams, bodies, Raycaster(beams, sensor).cast(bodies, walls, context))


def outline(axes: Axes, frame: WorldFrame, *, along_y: bool = False, **style: object) -> None:
    """Draw the boxes of all actors in plan, with x to the right or, `along_y`, upwards."""
    for pose, size in zip(frame.actors.pose_world, frame.actors.size, strict=True):
        turn = np.array([[np.cos(pose[2]), np.sin(pose[2])], [-np.sin(pose[2]), np.cos(pose[2])]])
        x, y = (pose[:2] + 0.5 * _CORNERS * size[:2] @ turn).T
        axes.plot(*((y, x) if along_y else (x, y)), **{"color": "0.7", "linewidth": 1.0, **style})


def sheet(rows: int, columns: int, width: float, height: float) -> tuple[Figure, npt.NDArray[np.object_]]:
    """Return a figure with panels (rows, columns); size in inches."""
    return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", squeeze=False)


def label(axes: Axes, title: str, x: str, y: str) -> None:
    """Set the title and the axis labels of a panel."""
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)


def save(figure: Figure, name: str) -> None:
    """Write a picture, in few colours to keep it small."""
    path = FOLDER / f"sensor_{name}.png"
    figure.savefig(path, dpi=95)
    plt.close(figure)
