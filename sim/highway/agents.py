"""Drivers and actions of an environment's agents, the first of which is the ego."""

from typing import Any

import numpy as np

from luxloop.sim.source import TrafficInputError


def install_drivers(env: Any, *, ego: bool) -> None:
    """Replace agents by drivers of the same class as other vehicles, with their routes and in all lists of the road.

    A car park has no road to follow: its agents stay as they are, and stand.

    Parameters
    ----------
    env
        Environment after its reset.
    ego
        Replace the ego, too; else only further agents.
    """
    from highway_env.envs.parking_env import ParkingEnv
    from highway_env.utils import class_from_path

    if isinstance(env, ParkingEnv):
        return
    kind = class_from_path(env.config["other_vehicles_type"])
    for n, agent in enumerate(env.controlled_vehicles):
        if n or ego:
            driver = _make_driver(agent, kind)
            env.road.vehicles[env.road.vehicles.index(agent)] = driver
            env.controlled_vehicles[n] = driver
    env.define_spaces()  # links observations and actions to the new vehicles


def _make_driver(agent: Any, kind: Any) -> Any:
    """Return a driver of a class with an agent's state, on slipping tyres if the agent has them."""
    from highway_env.vehicle.controller import ControlledVehicle
    from highway_env.vehicle.dynamics import BicycleVehicle

    if isinstance(agent, ControlledVehicle):
        driver = kind.create_from(agent)
    elif isinstance(agent, BicycleVehicle):

        class OnTyres(kind, BicycleVehicle):  # type: ignore[misc]  # behaviour of the first, dynamics of the second
            pass

        driver = OnTyres(agent.road, agent.position, agent.heading, agent.speed)
    else:
        driver = kind(agent.road, agent.position, agent.heading, agent.speed)
    for name, value in vars(agent).items():  # goals and target speeds that the rewards need
        vars(driver).setdefault(name, value)
    return driver


def idle_action(env: Any) -> Any:
    """Return the idle action of all agents."""
    return _idle_action(env.action_type)


def _idle_action(action_type: Any) -> Any:
    from highway_env.envs.common.action import DiscreteAction, DiscreteMetaAction, MultiAgentAction

    match action_type:
        case MultiAgentAction():
            return tuple(_idle_action(agent) for agent in action_type.agents_action_types)
        case DiscreteMetaAction():
            return action_type.actions_indexes["IDLE"]
        case DiscreteAction():  # a grid over the axes, in row-major order
            return action_type.space().n // 2
        case _:
            return np.zeros(action_type.size, dtype=np.float32)


def controlled_action(env: Any, name: str, action: Any) -> Any:
    """Return the joint action with the ego's action; the other agents, whose drivers ignore actions, idle.

    Raises
    ------
    TrafficInputError
        The action is invalid for the ego of the environment called `name`.
    """
    from gymnasium.spaces import Box, Tuple

    multi_agent = isinstance(env.action_space, Tuple)
    space = env.action_space[0] if multi_agent else env.action_space
    try:
        ego_action = np.asarray(action, dtype=space.dtype) if isinstance(space, Box) else action
    except (TypeError, ValueError):
        ego_action = None
    if ego_action is None or not space.contains(ego_action):
        shown = " ".join(str(action).split())
        raise TrafficInputError(f"action = {shown} is not among {name}'s actions, {space}; choose one of these")
    return (ego_action, *idle_action(env)[1:]) if multi_agent else ego_action
