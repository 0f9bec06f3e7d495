"""Echoes that come from no surface in the beam's way: which kinds there are in a run, and how they join the others."""

from functools import partial

import numpy as np

from sensor_model.bodies.scene import Bodies
from sensor_model.bodies.walls import Walls
from sensor_model.noise.clutter_mixing import Clutter, merge
from sensor_model.noise.false_alarms import false_alarms
from sensor_model.noise.ghosts import Mirrors
from sensor_model.noise.noise_config import NoiseConfig
from sensor_model.noise.rain import drops
from sensor_model.noise.random_draws import Draws
from sensor_model.noise.spray import clusters, spray_echoes
from sensor_model.noise.thresholds import Thresholds
from sensor_model.raycaster import Echoes, Raycaster
from sensor_model.returns import Returns
from sensor_model.rig.beams import BeamTable
from sensor_model.scan_context import ScanContext
from sim.world import WorldFrame


class Clutterer:
    """Adds ghosts, false alarms, raindrops and spray to what comes back from surfaces."""

    def __init__(self, noise: NoiseConfig, beams: BeamTable, caster: Raycaster, draws: Draws) -> None:
        self._noise = noise
        self._beams = beams
        self._caster = caster
        self._draws = draws
        self._mirrors = Mirrors(noise.ghost, beams)
        self._nothing_in_the_way = np.full(len(beams), np.inf)

    @property
    def needs_free_range(self) -> bool:
        """Whether it matters how far beams get: droplets behind a surface are not seen."""
        return self._noise.rain.enabled or self._noise.spray.enabled

    def add(
        self, returns: Returns, echoes: Echoes, bodies: Bodies, walls: Walls, setting: ScanContext, needed: Thresholds,
        frame: WorldFrame,
    ) -> Returns:  # fmt: skip
        """Return the returns of a frame with all that else makes an echo."""
        noise, beams, draws = self._noise, self._beams, self._draws
        time = self._caster.firing_time(setting)
        clutter: list[Clutter] = []
        if noise.ghost.enabled:
            follow = partial(self._caster.cast_mirrored, bodies=bodies, walls=walls, setting=setting)
            clutter.append(self._mirrors.ghosts(returns, bodies, setting, time, follow))
        if noise.false_alarms.enabled:
            clutter.append(false_alarms(noise.false_alarms, beams, needed, draws, frame.index))
        if noise.rain.enabled:
            clutter.append(drops(noise.rain, beams, needed, draws, frame.index))
        if noise.spray.enabled:
            cloud = clusters(noise.spray, bodies, frame.actors.id, draws, frame.time)
            clutter.append(spray_echoes(noise.spray, cloud, setting, time, beams, needed, draws))
        free_range = echoes.free_range if self.needs_free_range else self._nothing_in_the_way
        return merge(returns, clutter, free_range, beams)
