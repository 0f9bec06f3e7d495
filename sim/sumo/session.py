"""The simulation that libsumo runs in this process: one at a time."""

from pathlib import Path
from typing import Any, ClassVar

from luxloop.sim.source import SimulatorFailedError, StartReport, StartStatus, TrafficInputError, ignore_status
from luxloop.sim.sumo.error_messages import captured_stderr, one_line
from luxloop.sim.sumo.input_checks import clean_up, input_files, sumo_command
from luxloop.sim.sumo.opendrive_net import converted
from luxloop.sim.sumo.sumo_config import OPENDRIVE, SumoTraffic


class SumoSession:
    """A simulation of some traffic.

    Parameters
    ----------
    config
        Traffic to simulate.
    folder
        Folder of the scenario file.
    """

    _running: ClassVar["SumoSession | None"] = None

    def __init__(self, config: SumoTraffic, folder: Path):
        self._config = config
        self._folder = folder
        self._sumo: Any = None
        self.command: list[str] = []
        """SUMO's command line, since `start`."""

    @property
    def net(self) -> Path:
        """Path of the net, since `start`."""
        return Path(self.command[self.command.index("--net-file") + 1])

    def start(self, seed: int, report: StartReport = ignore_status) -> Any:
        """Start SUMO without output on the terminal and return libsumo.

        Parameters
        ----------
        seed
            Seed of SUMO.
        report
            Called before SUMO loads the net.

        Raises
        ------
        TrafficInputError
            The input is invalid; SUMO's messages are part of the error.
        SimulatorFailedError
            Another simulation runs in this process.
        """
        self.close()
        if SumoSession._running is not None:
            raise SimulatorFailedError("libsumo runs one simulation per process: close the other source first")
        self.command = self._command(seed)
        import libsumo

        self._sumo, SumoSession._running = libsumo, self
        (net,) = input_files(self.command, ["net-file"])
        report(StartStatus(f"SUMO loads {net.name} ({net.stat().st_size / 1e6:.1f} MB)", file=str(net.resolve())))
        with captured_stderr() as captured:
            try:
                libsumo.start(self.command)
            except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
                captured.seek(0)
                message = captured.read().decode(errors="replace") or str(error)
                self.close()
                raise self.input_error(message) from error
            except BaseException:
                self.close()
                raise
        return libsumo

    def input_error(self, message: str) -> TrafficInputError:
        """Return the error for a message of SUMO about its input."""
        return TrafficInputError(f"SUMO: {one_line(message, self.command)}")

    def close(self) -> None:
        """End the simulation if it is running."""
        if self._sumo is not None:
            self._sumo.close()
            self._sumo = SumoSession._running = None
            clean_up()

    def _command(self, seed: int) -> list[str]:
        config = self._config
        if config.config:
            files = {"configuration-file": [config.config]}
        else:
            opendrive = config.net.endswith(OPENDRIVE)
            net = converted(self._folder, config.net, config.netconvert) if opendrive else config.net
            files = {
                "net-file": [net],
                "route-files": config.routes,
                "additional-files": config.additional,
            }
        # by default SUMO removes an ego that collides
        options = {"collision.action": "warn"} if config.ego_control else {}
        return sumo_command(self._folder, files, config.dt_s, seed, options | config.options, config.begin_s)
