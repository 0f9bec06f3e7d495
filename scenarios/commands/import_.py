"""`luxloop import`."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from luxloop.printable import print_text
from luxloop.scenarios.commands.arguments import finite, grouped, require_of

if TYPE_CHECKING:
    from luxloop.scenarios.recordings.ego_mount import EgoMount
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions
    from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut
    from luxloop.scenarios.recordings.sweep import RecordingSource
    from luxloop.sensor_model.rig.rig import Rig


class Clock(StrEnum):
    """Times of ROS messages."""

    STAMP = "stamp"
    LOG = "log"


class TimeUnit(StrEnum):
    """Units of the times of points."""

    S = "s"
    MS = "ms"
    US = "us"
    NS = "ns"


UNITS_S = {TimeUnit.S: 1.0, TimeUnit.MS: 1e-3, TimeUnit.US: 1e-6, TimeUnit.NS: 1e-9}
"""[s]"""


@dataclass(frozen=True, slots=True)
class Mounting:
    """Mounts of the LIDARs on the ego."""

    rig: Annotated[str | None, typer.Option(metavar="FILE", help="Rig file with the mounts of the LIDARs.")] = None
    mount: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y,Z[,YAW,PITCH,ROLL]",
            help="Mount of a LIDAR in the ego frame [m, degrees], instead of a rig file; one per LIDAR.",
        ),
    ] = None
    level: Annotated[
        bool, typer.Option("--level", help="Take height, pitch and roll of the mounts from the ground in the scan.")
    ] = False


@dataclass(frozen=True, slots=True)
class Sources:
    """Topics, poses and times to read from the files."""

    topic: Annotated[
        list[str] | None, typer.Option(help="Topic of LIDAR points; one per LIDAR, in the order of the mounts.")
    ] = None
    odometry: Annotated[
        str | None, typer.Option(metavar="TOPIC", help="Poses of the ego: TOPIC, or TOPIC:PARENT:CHILD of transforms.")
    ] = None
    truth: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FILE|TOPIC=L,W[,X,Y[,H]]",
            help="File of true boxes, as for luxloop grade; or topic of the true poses of a vehicle, its box, and the "
            "box's centre in their frame [m].",
        ),
    ] = None
    truth_delay: Annotated[
        float,
        typer.Option(callback=finite, help="Time by which the true boxes lag behind the scans [s]."),
    ] = 0.0
    sweep_time: Annotated[
        float | None,
        typer.Option(
            min=0.0, callback=finite, help="Duration of a sweep [s], where points have no times or wrong ones."
        ),
    ] = None
    rate: Annotated[
        float, typer.Option(min=0.001, callback=finite, help="Sweeps per second, where files have no times.")
    ] = 10.0
    time: Annotated[
        Clock,
        typer.Option(help="Times of ROS messages: their stamps, or those of logging if clocks differ."),
    ] = Clock.STAMP
    time_unit: Annotated[
        TimeUnit | None,
        typer.Option(help="Unit of the times of points; by their type and the duration of a sweep if left out."),
    ] = None
    scene: Annotated[
        str | None, typer.Option(metavar="NAME", help="Scene, sequence or log of a data set that has several.")
    ] = None
    metadata: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Metadata of an Ouster sensor (JSON), if not beside the capture."),
    ] = None


@dataclass(frozen=True, slots=True)
class Cut:
    """Points to keep."""

    layers: Annotated[
        str | None, typer.Option(metavar="DEG,DEG,...", help="Keep the rings nearest to these elevations [degrees].")
    ] = None
    heights: Annotated[
        str | None,
        typer.Option(metavar="M,M,...", help="Keep the points nearest to these heights above the ground [m]."),
    ] = None
    height_tolerance: Annotated[
        float, typer.Option(min=0.001, callback=finite, help="Largest distance from --heights [m].")
    ] = 0.08
    azimuth_step: Annotated[
        float, typer.Option(min=0.001, callback=finite, help="Azimuth step of --heights [degrees].")
    ] = 0.5
    keep_heights: Annotated[
        str | None,
        typer.Option(metavar="LOW,HIGH", help="Keep only points between these heights above the ground [m]."),
    ] = None


@dataclass(frozen=True, slots=True)
class Scale:
    """Factors for model cars."""

    scale_length: Annotated[float, typer.Option(callback=finite, help="Factor on all lengths, for model cars.")] = 1.0
    scale_time: Annotated[
        float, typer.Option(callback=finite, help="Factor on all times; the root of the other keeps accelerations.")
    ] = 1.0


NO_MOUNTING = Mounting()
NO_SOURCES = Sources()
NO_CUT = Cut()
NO_SCALE = Scale()


@grouped
def import_(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Files of one recording, of one format.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder of the recorded scans.")],
    format_name: Annotated[
        str | None,
        typer.Option("--format", help="One of {open_recording}; by the names of the files if left out."),
    ] = None,
    mounting: Mounting = NO_MOUNTING,
    sources: Sources = NO_SOURCES,
    cut: Cut = NO_CUT,
    scale: Scale = NO_SCALE,
) -> None:
    """Make recorded scans of a recording: ROS bags, MCAP, PCD, Ouster, LUX, nuScenes, Argoverse 2, KITTI, Parquet."""
    from luxloop.scenarios.recordings.formats.format_choice import format_of, open_recording
    from luxloop.scenarios.recordings.import_options import ImportOptions, TruthOption
    from luxloop.scenarios.recordings.import_recording import import_recording
    from luxloop.scenarios.recordings.layer_cut import interval

    chosen = format_of(files, format_name)
    require_of("import", chosen)
    source = open_recording(files, chosen, _read_options(sources))
    rig_model, mounts = _mounts(mounting.rig, mounting.mount or [], source)
    truth_files = [Path(text) for text in sources.truth or [] if Path(text).exists()]
    options = ImportOptions(
        mounts=tuple(mounts),
        level=mounting.level,
        cut=_cut(cut),
        odometry=sources.odometry,
        truth=tuple(TruthOption.parse(text) for text in sources.truth or [] if Path(text) not in truth_files),
        truth_files=tuple(truth_files),
        truth_delay_s=sources.truth_delay,
        heights_m=interval("--keep-heights", cut.keep_heights) if cut.keep_heights else None,
        sweep_time_s=sources.sweep_time,
        scale_length=scale.scale_length,
        scale_time=scale.scale_time,
        files=tuple(path.name for path in files),
    )
    found = import_recording(source, options, out, rig_model)
    print_text(
        f"{found.frames} scans of {found.duration_s:.1f} s, {found.points} points in {found.layers} layers, "
        f"are in {out}; to track: luxloop track {out}"
    )
    if found.skipped:
        print_text(
            "Sweeps left out: "
            + ", ".join(f"{number} {reason.replace('_', ' ')}" for reason, number in found.skipped.items())
            + (f"; {found.clocks}" if found.clocks else "")
        )


def _read_options(sources: Sources) -> "ReadOptions":
    from luxloop.scenarios.recordings.formats.format_choice import ReadOptions

    return ReadOptions(
        topics=tuple(sources.topic or []),
        rate_hz=sources.rate,
        metadata=sources.metadata,
        by_log=sources.time == Clock.LOG,
        time_unit_s=UNITS_S[sources.time_unit] if sources.time_unit else None,
        scene=sources.scene,
    )


def _mounts(
    rig: str | None, mounts: list[str], source: "RecordingSource"
) -> "tuple[Rig | None, tuple[EgoMount, ...] | list[EgoMount]]":
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.recordings import ego_mount
    from luxloop.scenarios.recordings.sweep import DataSet

    if not rig and not mounts and isinstance(source, DataSet) and source.mounts:
        return None, source.mounts
    if bool(rig) == bool(mounts):
        raise InputError("give the places of the LIDARs on the ego: either --rig FILE, or --mount X,Y,Z for each")
    if rig:
        return ego_mount.of_rig(rig)
    return None, [ego_mount.EgoMount.parse(text) for text in mounts]


def _cut(cut: Cut) -> "ElevationCut | HeightCut | None":
    from luxloop.scenarios.errors import InputError
    from luxloop.scenarios.recordings.layer_cut import ElevationCut, HeightCut, numbers

    if cut.layers and cut.heights:
        raise InputError("--layers and --heights are both given; give one, they choose layers in different ways")
    if cut.layers:
        return ElevationCut(numbers("--layers", cut.layers))
    if not cut.heights:
        return None
    return HeightCut(numbers("--heights", cut.heights), cut.height_tolerance, cut.azimuth_step)
