"""The filter bank of one track, without a track around it."""

import numpy as np
from support.filter_bank import Filters

from luxloop.tracker.tracking.filters import FilterConfig, initial_filters
from luxloop.tracker.tracking.mma import MmaConfig
from luxloop.tracker.tracking.model_selection import model_selection
from luxloop.tracker.tracking.track_table import empty

ROW = np.zeros(1, dtype=np.int64)


class OneBank:
    """A table of one track at the origin, with a model selection."""

    def __init__(self, covariance, config=None, mma=None, selection=None):
        config = config or FilterConfig()
        self.selection = selection or model_selection(mma or MmaConfig())
        self.table = empty(config.models, rows=1)
        self.table.mean[0], self.table.covariance[0] = initial_filters(np.zeros(2), covariance, config)
        self.table.probability[0] = 1.0 / len(config.models)
        self.selection.summarise(self.table, ROW)

    def predict(self, motion):
        self.selection.predict(self.table, motion.models, motion.dt)

    def observe(self, innovation, noise):
        self.selection.correct(self.table, ROW, np.asarray(innovation)[None], noise[None])

    @property
    def filters(self):
        return Filters(self.table.mean[0].copy(), self.table.covariance[0].copy())

    @property
    def probability(self):
        return self.table.probability[0]

    @property
    def estimate(self):
        return self.table.estimate[0], self.table.estimate_covariance[0]

    @property
    def weights(self):
        return self.selection.weights(self.table)[0]
