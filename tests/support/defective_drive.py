"""Drive of a league with a defect that only worker processes meet."""

from multiprocessing import parent_process

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.league.drive import Drive


class DefectiveDrive(Drive):
    """Drive that worker processes cannot load."""

    def load(self) -> Scenario:
        """Load the scenario, in the process of the command only."""
        if parent_process() is not None:
            raise ZeroDivisionError("planted")
        return Drive.load(self)
