"""Peers of the shipped tracker with their tuned settings, as plug-ins of the group `luxloop.trackers`."""

from pathlib import Path

from luxloop.scenarios.files import input_file
from luxloop.scenarios.league.entrants import Entrant

PARAMETERS = Path(__file__).parent / "parameters.toml"
"""Settings by name, written by `docs/tune_league.py`."""
_TUNED = input_file.read_toml(PARAMETERS)
_TRACKERS = "luxloop.scenarios.league.trackers"


def _peer(name: str, place: str, text: str, extra: str = "") -> Entrant:
    return Entrant(name, f"{_TRACKERS}.{place}", text, _TUNED.get(name, {}), extra)


PAPER = _peer("paper", "paper_variant:paper_variant", "the paper's own steps")
AUTOWARE_BICYCLE = _peer(
    "autoware-bicycle", "autoware_bicycle:AutowareBicycle", "Autoware's fit, Hungarian, two-axle EKF"
)
NEAREST_NEIGHBOUR = _peer(
    "nearest-neighbour", "nearest_neighbour:NearestNeighbour", "Stone Soup: GNN, Kalman filter", "league"
)
JPDA = _peer("jpda", "joint_probabilistic:JointProbabilistic", "Stone Soup: JPDA, Kalman filter", "league")
PARTICLE_FILTER = _peer(
    "particle-filter", "particle_filter:ParticleFilter", "Stone Soup: GNN, particle filter", "league"
)
MULTI_HYPOTHESIS = _peer(
    "multi-hypothesis", "multi_hypothesis:MultiHypothesis", "Stone Soup: multi-frame assignment", "league"
)
NORFAIR = _peer("norfair", "norfair_points:NorfairPoints", "norfair-enough: greedy, Kalman filter", "league")
