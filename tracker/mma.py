"""Multiple-model association: which filter of the bank explains the vehicle best, equations (10) to (12)."""

from dataclasses import dataclass

import numpy as np

from tracker.records import MODELS, Floats


@dataclass(frozen=True, slots=True)
class MmaConfig:
    """Multiple-model association."""

    probability_floor: float = 0.02
    """No model's probability falls below this, so that it can come back when the vehicle changes its mind."""

    def __post_init__(self) -> None:
        if not 0 < self.probability_floor < 1 / len(MODELS):
            raise ValueError(f"probability_floor must lie between 0 and 1/{len(MODELS)}")


def initial_probability() -> Floats:
    """(M,) all models alike."""
    return np.full(len(MODELS), 1 / len(MODELS))


def update(probability: Floats, log_likelihood: Floats, config: MmaConfig) -> Floats:
    """(M,) model probabilities after one observation, equation (12) in logarithms.

    Parameters
    ----------
    probability
        (M,) before the observation, all above 0.
    log_likelihood
        (M,) logarithm of (11) under each model. A common offset cancels, so that no outlier can underflow.
    """
    score = np.log(probability) + log_likelihood
    posterior = np.exp(score - score.max())
    posterior = np.maximum(posterior / posterior.sum(), config.probability_floor)
    return np.asarray(posterior / posterior.sum())
