"""Who drives an environment's agents, the first of which is the ego, and which actions they are given."""

from typing import Any

import numpy as np

from sim.source import TrafficInputError


def put_drivers(env: Any, *, ego: bool) -> None:
    """Put drivers as the others have in the places of the agents, on their routes, where they and the road find them.

    On a car park there is no road to follow: agents stay as they are, and stand.

    Parameters
    ----------
    env
        An environment after its reset.
    ego
        Whether the ego gets a driver, too, or further agents only.
    """
    from highway_env.envs.parking_env import ParkingEnv
    from highway_env.utils import class_from_path

    if isinstance(env, ParkingEnv):
        return
    kind = class_from_path(env.config["other_vehicles_type"])
    for n, agent in enumerate(env.controlled_vehicles):
        if n or ego:
            driver = _driver_of(agent, kind)
            env.road.vehicles[env.road.vehicles.index(agent)] = driver
            env.controlled_vehicles[n] = driver
    env.define_spaces()  # links observations and actions to the new vehicles


def _driver_of(agent: Any, kind: Any) -> Any:
    """Return a driver of a kind in the state of an agent, and with tyres that slip if the agent's do."""
    from highway_env.vehicle.controller import ControlledVehicle
    from highway_env.vehicle.dynamics import BicycleVehicle

    if isinstance(agent, ControlledVehicle):
        driver = kind.create_from(agent)
    elif isinstance(agent, BicycleVehicle):

        class OnTyres(kind, BicycleVehicle):  # type: ignore[misc]  # decides as the first, moves as the second
            pass

        driver = OnTyres(agent.road, agent.position, agent.heading, agent.speed)
    else:
        driver = kind(agent.road, agent.position, agent.heading, agent.speed)
    for name, value in vars(agent).items():  # goals and target speeds that rewards ask for
        vars(driver).setdefault(name, value)
    return driver


def idle(env: Any) -> Any:
    """Return the action of all agents by which nobody does anything."""
    return _idle(env.action_type)


def _idle(action_type: Any) -> Any:
    from highway_env.envs.common.action import DiscreteAction, DiscreteMetaAction, MultiAgentAction

    match action_type:
        case MultiAgentAction():
            return tuple(_idle(agent) for agent in action_type.agents_action_types)
        case DiscreteMetaAction():
            return action_type.actions_indexes["IDLE"]
        case DiscreteAction():  # a grid over the axes, counted row by row
            return action_type.space().n // 2
        case _:
            return np.zeros(action_type.size, dtype=np.float32)


def obeying(env: Any, name: str, action: Any) -> Any:
    """Return the action of all agents in which the ego does as told; the others', whose drivers heed none, idle.

    Raises
    ------
    TrafficInputError
        The ego of the environment called `name` has no such action.
    """
    from gymnasium.spaces import Box, Tuple

    several = isinstance(env.action_space, Tuple)
    space = env.action_space[0] if several else env.action_space
    try:
        own = np.asarray(action, dtype=space.dtype) if isinstance(space, Box) else action
    except (TypeError, ValueError):
        own = None
    if own is None or not space.contains(own):
        told = " ".join(str(action).split())
        raise TrafficInputError(f"action = {told} is not among {name}'s actions, {space}; give one of these")
    return (own, *idle(env)[1:]) if several else own
