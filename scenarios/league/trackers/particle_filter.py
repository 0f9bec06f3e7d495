"""Particle filter with global nearest neighbour association, by Stone Soup."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any, ClassVar

import numpy as np

from luxloop.arrays import Floats
from luxloop.scenarios.league.trackers.nearest_neighbour import NearestNeighbour
from luxloop.scenarios.league.trackers.stone_soup import SPEED_STD_MPS, Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleSettings(Settings):
    """Settings of the particle filter."""

    particles: int = 500


class ParticleFilter(NearestNeighbour):
    """Bootstrap filter with systematic resampling; all draws follow from a fixed seed."""

    settings_type: ClassVar[type[Settings]] = ParticleSettings

    def filter(self) -> tuple[Any, Any]:
        """Return the predictor and the updater."""
        from stonesoup.predictor.particle import ParticlePredictor
        from stonesoup.resampler.particle import SystematicResampler
        from stonesoup.updater.particle import ParticleUpdater

        rng = self._rng = np.random.default_rng(0)

        class SeededResampler(SystematicResampler):  # type: ignore[misc]
            """Stone Soup's resampler draws from numpy's global generator; this one from the tracker's own."""

            def resample(self, particles: Any, nparts: int | None = None) -> Any:
                count = nparts or len(particles)
                share = np.exp(particles.log_weight - np.max(particles.log_weight))
                places = (rng.random() + np.arange(count)) / count * share.sum()
                kept = particles[np.minimum(np.searchsorted(np.cumsum(share), places), len(share) - 1)]
                kept.log_weight = np.full(count, -np.log(count))
                return kept

        return ParticlePredictor(self.motion), ParticleUpdater(self.measured, SeededResampler())

    def first_state(self, center: Floats, now: datetime) -> Any:
        """Return the particles of a new track at `center` (2,)."""
        from stonesoup.types.array import StateVectors
        from stonesoup.types.state import ParticleState

        own = self.settings
        assert isinstance(own, ParticleSettings)
        std = np.array([own.position_std_m, SPEED_STD_MPS] * 2)
        drawn = np.array([center[0], 0.0, center[1], 0.0])[:, None] + std[:, None] * self._rng.standard_normal(
            (4, own.particles)
        )
        weight = np.full(own.particles, -np.log(own.particles))
        return ParticleState(StateVectors(drawn), log_weight=weight, timestamp=now)
