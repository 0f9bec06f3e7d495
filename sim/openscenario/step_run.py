"""States of the elements of stories: standby, running and complete."""

from typing import Any, Protocol

from luxloop.sim.openscenario.conditions import Scene, TriggerWatch
from luxloop.sim.openscenario.storyboard import Action, Step
from luxloop.sim.xml_tree import XmlElement

MOMENTS = 1
"""Instants for which a transition remains visible, so that conditions that are evaluated earlier notice it."""


class Performer(Protocol):
    """Performer of the actions of events."""

    def begin(self, name: str, action: Action, source: XmlElement) -> Any:
        """Begin an action of an entity, and return the change that it makes."""
        ...

    def runs(self, name: str, change: Any) -> bool:
        """Return whether a change is still in effect and not done."""
        ...

    def end(self, name: str, change: Any) -> None:
        """End a change, if it is still in effect."""
        ...

    @property
    def instant(self) -> int:
        """Number of the evaluation."""
        ...


class StepRun:
    """An element of a story with its state and those below it."""

    def __init__(self, step: Step):
        self.step = step
        self.state = "standbyState"
        self.children = [StepRun(child) for child in step.children]
        self._executions = 0
        self._transitions: dict[str, int] = {}
        self._changes: list[tuple[str, Any]] = []
        self._arm()

    def all(self) -> list["StepRun"]:
        """Return the element and all below it."""
        return [self, *(one for child in self.children for one in child.all())]

    @property
    def has_started(self) -> bool:
        """Return whether the element has started or been skipped."""
        return bool({"startTransition", "skipTransition"} & self._transitions.keys())

    def has_state(self, state: str, instant: int) -> bool:
        """Return whether the element has a state, or has just made a transition."""
        return self.state == state or instant - self._transitions.get(state, -10) <= MOMENTS

    def update(self, scene: Scene, performer: Performer, siblings: tuple["StepRun", ...] = ()) -> None:
        """Evaluate the triggers of the element and of those below it, and begin or end its actions."""
        if self.state == "standbyState" and (self._start is None or self._start.fires(scene)):
            self._begin(performer, siblings)
        if self.state == "runningState":
            if self._stop is not None and self._stop.fires(scene):
                self.terminate(performer)
                return
            for child in self.children:
                child.update(scene, performer, tuple(one for one in self.children if one is not child))
            if self._is_done(performer):
                self._finish(performer)

    def terminate(self, performer: Performer) -> None:
        """Stop the element and those below it."""
        for name, change in self._changes:
            performer.end(name, change)
        for child in self.children:
            child.terminate(performer)
        if self.state != "completeState":
            self._enter("completeState", "stopTransition", performer)

    def _arm(self) -> None:
        """Make triggers without history."""
        self._start = TriggerWatch(self.step.start) if self.step.start else None
        self._stop = TriggerWatch(self.step.stop) if self.step.stop else None

    def _begin(self, performer: Performer, siblings: tuple["StepRun", ...]) -> None:
        running = [one for one in siblings if one.state == "runningState"]
        if self.step.priority == "skip" and running:
            self._executions += 1
            self._rest("skipTransition", performer)
            return
        for other in running if self.step.priority == "override" else []:
            other.terminate(performer)
        self._enter("runningState", "startTransition", performer)
        self._changes = [(name, performer.begin(name, action, source)) for name, action, source in self.step.actions]

    def _is_done(self, performer: Performer) -> bool:
        if self.step.kind == "event":
            return not any(performer.runs(name, change) for name, change in self._changes)
        return all(child.state == "completeState" for child in self.children)

    def _finish(self, performer: Performer) -> None:
        self._executions += 1
        self._rest("endTransition", performer)

    def _rest(self, transition: str, performer: Performer) -> None:
        """Complete the element, or await its next execution."""
        done = self.step.kind != "event" or self._executions >= self.step.count
        self._enter("completeState" if done else "standbyState", transition, performer)
        if not done:
            self._arm()

    def _enter(self, state: str, transition: str, performer: Performer) -> None:
        self.state = state
        self._transitions[transition] = performer.instant
