"""Errors that a user can correct. Each message is one line: place, key, wrong value, remedy.

- `InputError`, a `luxloop.Error` like those of traffic and rigs, with the subclasses
    - `ScenarioError`: the scenario file
    - `StudyError`: the study file
    - `DeviceError`: the tracker named by --tracker; `ContractError`, exit code 4: it runs and breaks its contract
    - `MetricError`: a function of the `[[metric]]` tables
    - `OutputError`: the folder of results
    - `TracksError`: a file of tracks, or of true boxes
"""

from luxloop.errors import Error


class InputError(Error):
    """The request cannot be carried out."""


class ScenarioError(InputError):
    """The scenario does not exist, or its file is invalid."""


class StudyError(InputError):
    """The study file is invalid, or names a file or object that does not exist."""


class DeviceError(InputError):
    """The named tracker cannot be imported, or does not satisfy the interface."""


class ContractError(DeviceError):
    """The tracker raised an exception, took too long, or returned invalid tracks."""


class MetricError(InputError):
    """A metric of the scenario file cannot be imported, fails, or returns no number."""


class OutputError(InputError):
    """Results cannot be written, or a folder holds no valid results."""


class TracksError(InputError):
    """A file of tracks or of true boxes cannot be read, or does not have the required layout."""


class Interrupted(Exception):
    """Ctrl-C, with a message on the partial results."""
