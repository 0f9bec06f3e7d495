"""Options of `luxloop new`."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from luxloop.scenarios.authoring.sumo_survey import WINDOW_S
from luxloop.scenarios.errors import InputError
from luxloop.sim.candidates.want import Want

_Paths = TypeVar("_Paths", str, list[str])


@dataclass(frozen=True, slots=True)
class DraftOptions:
    """Options of a new scenario."""

    out: Path
    """The scenario file."""
    duration_s: float
    seed: int
    want: Want
    ego: str
    """Id of the ego; empty to choose it."""
    begin_s: float | None
    """[s] Start of SUMO's clock."""
    window_s: float
    """[s] Time that is surveyed."""

    def refuse(self, why: str, *names: str) -> None:
        """Refuse options that some traffic has no use for.

        Parameters
        ----------
        why
            End of the message.
        names
            The options: `--ego`, `--begin`, `--want`, `--window`.

        Raises
        ------
        InputError
            One of them is not at its default.
        """
        changed = {
            "--ego": bool(self.ego),
            "--begin": self.begin_s is not None,
            "--want": self.want is not Want.NEIGHBOURS,
            "--window": self.window_s != WINDOW_S,
        }
        given = [name for name in names if changed[name]]
        if given:
            raise InputError(f"{' and '.join(given)}: {why}")

    def moved(self, names: _Paths, folder: Path) -> _Paths:
        """Return file names relative to `folder` as names relative to the scenario file."""
        if isinstance(names, str):
            return os.path.relpath(folder / names, self.out.parent) if names else names
        return [self.moved(name, folder) for name in names]
