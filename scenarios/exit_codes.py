"""Exit codes of the command line, and the errors behind them."""

from enum import IntEnum

from luxloop.scenarios.errors import ContractError, InputError
from luxloop.scenarios.files import disk_errors
from luxloop.scenarios.run import termination

INTERNAL_ERROR = "internal error: "
"""Begin of the `error` of a run that ended by a defect of luxloop, in rows and logs of studies."""


class ExitCode(IntEnum):
    """Exit codes of all commands."""

    PASSED = 0
    FAILED = 1
    """An expectation failed, or the run ended early."""
    BAD_INPUT = 2
    SIMULATOR_FAILED = 3
    BROKEN_TRACKER = 4
    CANNOT_TELL = 5
    """Of `luxloop compare`."""
    INTERNAL = 70
    """A defect of luxloop or of its installation; `EX_SOFTWARE` of sysexits.h."""
    INTERRUPTED = termination.CTRL_C


def explain(error: BaseException) -> tuple[ExitCode, str]:
    """Return the exit code of an error, and its message; `INTERNAL` is every error that no user can correct."""
    from luxloop.sensor_model.rig.rig import RigError
    from luxloop.sim.source import SimulatorFailedError, TrafficError

    if message := disk_errors.message(error):
        return ExitCode.BAD_INPUT, message
    if isinstance(error, SimulatorFailedError):
        return ExitCode.SIMULATOR_FAILED, str(error)
    if isinstance(error, ContractError):
        return ExitCode.BROKEN_TRACKER, str(error)
    if isinstance(error, InputError | RigError | TrafficError):
        return ExitCode.BAD_INPUT, str(error)
    return ExitCode.INTERRUPTED if termination.is_interrupt(error) else ExitCode.INTERNAL, str(error)
