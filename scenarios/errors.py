"""What goes wrong between a person and a run; every message is one line: what, where, the offending value, the remedy.

- `InputError`, of which there are
    - `ScenarioError`: the scenario file
    - `StudyError`: the study file
    - `DeviceError`: the tracker named by --tracker
    - `OutputError`: the folder of results
    - `TracksError`: a file of tracks
"""


class InputError(Exception):
    """What was asked for cannot be run."""


class ScenarioError(InputError):
    """No such scenario, or its file is wrong."""


class StudyError(InputError):
    """The study file is wrong, or names what is not there."""


class DeviceError(InputError):
    """What was named as a tracker cannot be imported, or is none."""


class OutputError(InputError):
    """Results cannot be written, or what should be results is none."""


class TracksError(InputError):
    """A file of tracks cannot be read, or breaks the layout."""


class Interrupted(Exception):
    """Ctrl-C, where there is more to say than that."""
