"""Clutter of a run: ghosts, false alarms and weather, merged with the returns of surfaces."""

from functools import partial

import numpy as np

from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.bodies.walls import Walls
from luxloop.sensor_model.noise.clutter_mixing import Clutter, merge
from luxloop.sensor_model.noise.false_alarms import false_alarms
from luxloop.sensor_model.noise.fog import FogEchoes
from luxloop.sensor_model.noise.ghosts import Mirrors
from luxloop.sensor_model.noise.noise_config import NoiseConfig
from luxloop.sensor_model.noise.rain import drops
from luxloop.sensor_model.noise.random_draws import Draws
from luxloop.sensor_model.noise.snow import flakes
from luxloop.sensor_model.noise.spray import clusters, spray_echoes
from luxloop.sensor_model.noise.thresholds import Thresholds
from luxloop.sensor_model.raycaster import Echoes, Raycaster
from luxloop.sensor_model.returns import Returns
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sim.world import WorldFrame


class ClutterSources:
    """Sources of clutter in a run: ghosts, false alarms, rain, spray, snow and fog."""

    def __init__(self, noise: NoiseConfig, beams: BeamTable, caster: Raycaster, draws: Draws) -> None:
        self._noise = noise
        self._beams = beams
        self._caster = caster
        self._draws = draws
        self._mirrors = Mirrors(noise.ghost, beams)
        self._fog = FogEchoes(noise.fog, beams) if noise.fog.enabled else None
        self._unlimited = np.full(len(beams), np.inf)

    @property
    def needs_free_range(self) -> bool:
        """True if the free range of beams is needed, because surfaces occlude droplets."""
        noise = self._noise
        return noise.rain.enabled or noise.spray.enabled or noise.snow.enabled or noise.fog.enabled

    def add(
        self, returns: Returns, echoes: Echoes, bodies: Bodies, walls: Walls, context: ScanContext,
        thresholds: Thresholds, frame: WorldFrame,
    ) -> Returns:  # fmt: skip
        """Return the returns of a frame merged with all clutter."""
        noise, beams, draws = self._noise, self._beams, self._draws
        time = self._caster.firing_time(context)
        clutter: list[Clutter] = []
        if noise.ghost.enabled:
            follow = partial(self._caster.cast_mirrored, bodies=bodies, walls=walls, context=context)
            clutter.append(self._mirrors.ghosts(returns, bodies, context, time, follow))
        if noise.false_alarms.enabled:
            clutter.append(false_alarms(noise.false_alarms, beams, thresholds, draws, frame.index))
        if noise.rain.enabled:
            clutter.append(drops(noise.rain, beams, thresholds, draws, frame.index))
        if noise.spray.enabled:
            cloud = clusters(noise.spray, bodies, frame.actors.name, draws, frame.time)
            clutter.append(spray_echoes(noise.spray, cloud, context, time, beams, thresholds, draws))
        if noise.snow.enabled:
            clutter.append(flakes(noise.snow, beams, thresholds, draws, frame.index))
        if self._fog is not None:
            clutter.append(self._fog.draw(thresholds, draws, frame.index))
        free_range = echoes.free_range if self.needs_free_range else self._unlimited
        return merge(returns, clutter, free_range, beams)
