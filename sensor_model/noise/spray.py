"""Spray of fast vehicles on a wet road."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from luxloop import elementary, elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.kernels.clusters import cluster_echoes
from luxloop.sensor_model.kernels.records import BeamAxes, Droplets, Fans, UnitPoses
from luxloop.sensor_model.noise.clutter_mixing import Clutter, droplets, unit_directions
from luxloop.sensor_model.noise.random_draws import Draws, Purpose
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.truth import Cause
from luxloop.sim.actor_draws import actor_key

CYCLE_S = 0.1
"""[s] Clusters are born at multiples of this, at any scan rate: the scan period of the unit of the measurements."""

_KM_PER_H = 3.6  # per m/s
_PLUME_WIDTH_M = 3.4
_PLUME_HEIGHT_M = 1.5
_DRAG_PER_M = 0.12  # deceleration of a cluster over its speed squared
_RADIUS_LOG_MEAN, _RADIUS_LOG_SIGMA, _RADIUS_MAX_M = -1.2, 0.8, 1.0
_SLOWEST_KM_PER_H = 50.0
_LIFE = 3.0  # time constants after which 5 % of a cluster is left


@dataclass(frozen=True, slots=True)
class Spray:
    """Clusters of droplets behind every fast vehicle.

    The constants were fitted to a Velodyne VLP-32 behind cars on a wetted track (TU Darmstadt's open model; Linnhoff
    et al. 2022, "Simulating Road Spray in Lidar Sensor Models").
    """

    enabled: bool = False
    """If false, the road is dry."""
    water_film_mm: float = 0.5
    """[mm] Depth of the water film on the road; an estimate for steady rain."""
    echo_share: float = 0.17
    """Share of the beams through a new cluster that get an echo: the mean of the model's lognormal share with
    parameters -2.3 and 1.1, limited to 1. Lower it for a unit that is less sensitive to droplets than the VLP-32."""
    reach_m: float = 40.0
    """[m] Clusters farther than this from the ego give no echo; an estimate."""
    labelled: float = 0.5
    """Share of the echoes that the unit flags as clutter; an estimate."""

    def __post_init__(self) -> None:
        if not 0.0 < self.water_film_mm <= 5.0:
            raise ValueError(
                f"water_film_mm = {self.water_film_mm}: must be above 0 and at most 5; use enabled = false for none"
            )
        if not 0.0 < self.echo_share <= 1.0:
            raise ValueError(f"echo_share = {self.echo_share}: must be above 0 and at most 1")
        if not 0.0 < self.reach_m <= 200.0:
            raise ValueError(f"reach_m = {self.reach_m}: must be above 0 and at most 200")
        if not 0.0 <= self.labelled <= 1.0:
            raise ValueError(f"labelled = {self.labelled}: must be from 0 to 1")


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """C spheres of droplets."""

    centre_ego: Floats
    """(C, 3) at the frame's time [m]."""
    radius: Floats
    """(C,) [m]."""
    share: Floats
    """(C,) share of the beams through a cluster that give an echo."""
    tag: Ints
    """(C,) random 32-bit number that identifies the cluster during its life."""


def clusters(config: Spray, bodies: Bodies, name: npt.NDArray[np.str_], draws: Draws, time: float) -> Clusters:
    """Return the clusters in the air at a time, at most slightly displaced from their place of birth.

    A vehicle of v > 50 km/h leaves (0.2 h + 0.1) (v - 50) clusters per `CYCLE_S` behind it, h the water film [mm], in a
    plume 3.4 m wide and 1.5 m high. Radii are lognormal. A cluster starts at the vehicle's speed V and is
    decelerated by drag, so that it has moved ln(1 + k V t) / k by the age t, k = 0.12 / m; its density decays as
    exp(-t / T) with T = 0.02 h (v - 50) + 0.2 s. The vehicle's past positions, where its clusters were born, follow
    from constant acceleration, so that no state is kept between frames.

    Parameters
    ----------
    name
        (A,) name of each body's actor: a cluster's draws depend only on it and on the time of birth.
    """
    found = [
        _wake(config, bodies, int(row), actor_key(str(name[row])), draws, time)
        for row in np.flatnonzero(elementwise.hypot(*bodies.velocity_ego.T) * _KM_PER_H > _SLOWEST_KM_PER_H)
    ]
    centre = np.concatenate([np.empty((0, 3)), *(wake.centre_ego for wake in found)])
    radius = np.concatenate([np.empty(0), *(wake.radius for wake in found)])
    share = np.concatenate([np.empty(0), *(wake.share for wake in found)])
    tag = np.concatenate([np.empty(0, dtype=np.int64), *(wake.tag for wake in found)])
    near = elementwise.hypot(centre[:, 0], centre[:, 1]) < config.reach_m
    return Clusters(centre[near], radius[near], share[near], tag[near])


def spray_echoes(
    config: Spray, cloud: Clusters, context: ScanContext, time: Floats, beams: BeamTable, thresholds: Thresholds,
    draws: Draws,
) -> Clutter:  # fmt: skip
    """Return the echoes of clusters: a beam gets one with the cluster's share, uniform over its chord.

    The nearest echo of a beam counts. Clusters between the units of the ego are dropped. The attenuation by clusters
    and the ego's rotation during the scan are neglected.

    Parameters
    ----------
    time
        (B,) true firing times relative to the frame's time [s].
    """
    cloud = _outside(cloud, context.origin_ego)
    nearest = cluster_echoes(
        draws.key, context.frame_index, int(Purpose.SPRAY_ECHO),
        Droplets(cloud.centre_ego, cloud.radius, cloud.share, cloud.tag),
        UnitPoses(context.origin_ego, context.R_ego_unit), context.ego_velocity,
        BeamAxes(beams.unit, beams.index, unit_directions(beams), time),
        Fans(beams.fan_unit, beams.fan_row, beams.fan_azimuth, beams.fan_turn, beams.row_beam),
    )  # fmt: skip
    beam = np.flatnonzero(nearest < np.inf)
    chance = draws.uniform(context.frame_index, beam, Purpose.SPRAY_LABEL)
    return droplets(beam, nearest[beam], Cause.SPRAY, config.labelled, chance, beams, thresholds)


def _outside(cloud: Clusters, origin_ego: Floats) -> Clusters:
    """Drop clusters that touch the bounding box in plan of the units (U, 3)."""
    low, high = origin_ego[:, :2].min(axis=0), origin_ego[:, :2].max(axis=0)
    beside = np.maximum(low - cloud.centre_ego[:, :2], cloud.centre_ego[:, :2] - high)
    out = beside.max(axis=1, initial=-np.inf) > cloud.radius
    return Clusters(cloud.centre_ego[out], cloud.radius[out], cloud.share[out], cloud.tag[out])


def _wake(config: Spray, bodies: Bodies, row: int, key: int, draws: Draws, time: float) -> Clusters:
    """Return the clusters of one vehicle, drawn by its key, time of birth and number."""
    key &= 0xFFFFFFFF  # a word of the counter
    velocity, acceleration = bodies.velocity_ego[row], bodies.acceleration_ego[row]
    speed = elementary.hypot(*velocity)
    excess = speed * _KM_PER_H - _SLOWEST_KM_PER_H
    lasting = 0.02 * config.water_film_mm * excess + 0.2
    birth = np.arange(math.ceil((time - _LIFE * lasting) / CYCLE_S), math.floor(time / CYCLE_S) + 1)
    chance, _ = draws.uniform_of(birth, 0, key, Purpose.SPRAY_BIRTH)
    born = np.floor((0.2 * config.water_film_mm + 0.1) * excess + chance).astype(np.int64)
    birth = np.repeat(birth, born)
    number = np.arange(len(birth)) - np.repeat(np.cumsum(born) - born, born)

    along, across = draws.uniform_of(birth, number, key, Purpose.SPRAY_PLACE)
    height, tag = draws.uniform_of(birth, number, key, Purpose.SPRAY_HEIGHT)
    size = draws.normal_of(birth, number, key, Purpose.SPRAY_RADIUS)
    age = time - birth * CYCLE_S
    behind = (
        bodies.bounds[row, 0, 0] - along * speed * CYCLE_S + elementwise.log1p(_DRAG_PER_M * speed * age) / _DRAG_PER_M
    )
    beside = (across - 0.5) * _PLUME_WIDTH_M
    cos, sin = elementary.cos(bodies.pose_ego[row, 2]), elementary.sin(bodies.pose_ego[row, 2])
    then = bodies.pose_ego[row, :2] - age[:, None] * velocity + age[:, None] ** 2 / 2.0 * acceleration
    centre = np.column_stack(
        [
            then[:, 0] + cos * behind - sin * beside,
            then[:, 1] + sin * behind + cos * beside,
            bodies.ground_z[row] + height * _PLUME_HEIGHT_M,
        ]
    )
    radius = np.minimum(elementwise.exp(_RADIUS_LOG_MEAN + _RADIUS_LOG_SIGMA * size), _RADIUS_MAX_M)
    return Clusters(
        centre, radius, config.echo_share * elementwise.exp(-age / lasting), (tag * 2.0**32).astype(np.int64)
    )
