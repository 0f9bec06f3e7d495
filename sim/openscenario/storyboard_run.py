"""Execution of a storyboard in small steps of time."""

from luxloop.sim.opendrive.road_network import RoadNetwork
from luxloop.sim.openscenario.conditions import TriggerWatch
from luxloop.sim.openscenario.placement import (
    leave_trajectory,
    place_all,
    require_lane,
    require_places,
    route,
    shifted_lane,
    trajectory,
)
from luxloop.sim.openscenario.speed_control import DistanceControl, SpeedChange
from luxloop.sim.openscenario.step_run import StepRun
from luxloop.sim.openscenario.storyboard import (
    Action,
    LaneChangeAction,
    RouteAction,
    SpeedAction,
    Storyboard,
    TrajectoryAction,
)
from luxloop.sim.openscenario.trajectory import Trajectory
from luxloop.sim.openscenario.traveller import LaneChange, Traveller
from luxloop.sim.xml_tree import XmlElement

AT_ONCE = 20
"""Evaluations at 0 s, so that events that start there are in effect in the first frame."""
JUST_AFTER = 1e-9
"""[s] Time of these evaluations: `SimulationTimeCondition` greaterThan 0 is true."""

Change = SpeedChange | DistanceControl | LaneChange | Trajectory


class StoryboardRun:
    """A storyboard that runs, with its entities.

    Parameters
    ----------
    board
        The storyboard.
    network
        Its roads.

    Raises
    ------
    TrafficInputError
        An entity is not on a lane, or a lane change leads to no lane.
    """

    def __init__(self, board: Storyboard, network: RoadNetwork):
        self.network = network
        self.travellers = place_all(board, network)
        require_places(board, network)
        self.time = 0.0
        self.stopped = False
        self.instant = 0
        self._steps = 0
        self._speeds: dict[str, SpeedChange | DistanceControl] = {}
        self._stories = [StepRun(story) for story in board.stories]
        self._runs = {(run.step.kind, run.step.name): run for top in self._stories for run in top.all()}
        self._stop = TriggerWatch(board.stop)
        self._start(board)

    def advance(self, step: float) -> None:
        """Move all entities by one step [s], always the same, and evaluate all triggers."""
        speeds = {name: self._new_speed(name, step) for name in self.travellers}
        for name, traveller in self.travellers.items():
            was_done = traveller.trajectory is not None and traveller.trajectory.done
            traveller.move(step, speeds[name])
            if traveller.trajectory and traveller.trajectory.done and not was_done:
                leave_trajectory(traveller)
        self.travellers = {name: one for name, one in self.travellers.items() if not one.gone}
        self._steps += 1
        self.time = round(self._steps * step, 9)
        self._evaluate()

    def has_state(self, element: tuple[str, str], state: str) -> bool:
        """Return whether a storyboard element has a state, or makes a transition at this or the previous instant."""
        return self._runs[element].has_state(state, self.instant)

    def never_started(self) -> list[str]:
        """Return the names of the events that have not started, nor been skipped, until now."""
        return [run.step.name for run in self._runs.values() if run.step.kind == "event" and not run.has_started]

    def begin(self, name: str, action: Action, source: XmlElement) -> Change | None:
        """Begin an action of an entity, in place of an earlier one in the same direction.

        Routes have no change that lasts: None, as for an entity that has left.
        """
        own = self.travellers.get(name)
        if own is None:
            return None
        match action:
            case RouteAction():
                require_lane(own, source)
                own.take_route(route(own, action, self.travellers, source), source)
                return None
            case TrajectoryAction():
                return self._begin_trajectory(name, own, action, source)
            case LaneChangeAction():
                self._leave_trajectory(own, source)
                own.end_lane_change()
                own.change_lane(action, self._target_lane(own, action, source))
                return own.change
        if own.trajectory and (own.trajectory.timed or own.trajectory.done):
            self._leave_trajectory(own, source)
        begun = (
            SpeedChange(action, own, self.travellers) if isinstance(action, SpeedAction) else DistanceControl(action)
        )
        self._speeds[name] = begun
        if isinstance(begun, SpeedChange):
            own.speed = begun.speed(0.0, own, self.travellers)
        return begun

    def runs(self, name: str, change: Change | None) -> bool:
        """Return whether an action that has begun is still in effect and not done."""
        own = self.travellers.get(name)
        if own is None or change is None:
            return False
        if isinstance(change, LaneChange):
            return own.change is change and change.progress < 1
        if isinstance(change, Trajectory):
            return own.trajectory is change and not change.done
        return self._speeds.get(name) is change and not change.done

    def end(self, name: str, change: Change | None) -> None:
        """End an action, if it is still in effect."""
        own = self.travellers.get(name)
        if own is not None and isinstance(change, LaneChange) and own.change is change:
            own.end_lane_change()
        elif own is not None and isinstance(change, Trajectory) and own.trajectory is change:
            leave_trajectory(own)
        elif change is not None and self._speeds.get(name) is change:
            del self._speeds[name]

    def _begin_trajectory(self, name: str, own: Traveller, action: TrajectoryAction, source: XmlElement) -> Trajectory:
        """Begin a trajectory in place of the lane; its times, if any, replace the speed."""
        begun = trajectory(own, action, self.time, self.travellers, source)
        own.end_lane_change()
        own.trajectory = begun
        if begun.timed:
            self._speeds.pop(name, None)
        return begun

    def _leave_trajectory(self, own: Traveller, source: XmlElement) -> None:
        """Return to the lane under a trajectory, for an action that needs it."""
        if own.trajectory and not leave_trajectory(own):
            require_lane(own, source)

    def _start(self, board: Storyboard) -> None:
        """Do the initial actions, those that depend on other entities last, and start what starts at 0 s."""
        for name, action, source in sorted(board.actions, key=lambda entry: _depends(entry[1])):
            self.begin(name, action, source)
        self._evaluate()
        self.time = JUST_AFTER
        for _ in range(AT_ONCE):
            self._evaluate()
        self.time = 0.0

    def _evaluate(self) -> None:
        self.instant += 1
        for story in self._stories:
            story.update(self, self)
        self.stopped = self._stop.fires(self) or self.stopped

    def _new_speed(self, name: str, step: float) -> float:
        control, own = self._speeds.get(name), self.travellers[name]
        return control.speed(step, own, self.travellers) if control else own.speed

    def _target_lane(self, own: Traveller, action: LaneChangeAction, source: XmlElement) -> int:
        lane = action.lane
        if action.entity:
            other = self.travellers.get(action.entity)
            if other is None:
                raise source.error(f'is relative to "{action.entity}", which has left the roads at {self.time:.2f} s')
            require_lane(other, source)
            lane = shifted_lane(other.lane, action.lane * other.forward)
        if not own.road.has_lane(own.s, lane):
            lanes = ", ".join(str(one) for one in sorted(own.road.section(own.s).lanes))
            raise source.error(
                f"leads to lane {lane}, which road {own.road.id} does not have at s = {own.s:.1f} ({self.time:.2f} s); "
                f"use one of {lanes}"
            )
        return lane


def _depends(action: Action) -> bool:
    return isinstance(action, SpeedAction | LaneChangeAction) and bool(action.entity)
