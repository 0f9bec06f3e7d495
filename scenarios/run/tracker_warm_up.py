"""Compilation of the tracker's kernels in a process of its own, beside that of traffic and sensor."""

import multiprocessing
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from luxloop.scenarios.run import progress
from luxloop.scenarios.run.guard import guarded
from luxloop.scenarios.run.warm_up import FRAMES, STATUS
from luxloop.sensor_model.rig.beams import beam_table, sweep_limits
from luxloop.sensor_model.rig.rig import Rig
from luxloop.sim.rare_collection import collect_rarely
from luxloop.tracker.scan import Scan
from luxloop.tracker.tracker import Tracker, TrackerConfig


@contextmanager
def tracker_beside(config: TrackerConfig, rig: Rig) -> Iterator[None]:
    """Compile the shipped tracker in another process, and wait for it at the end.

    A failure there is not reported: this process compiles the rest when it uses it, and meets the same failure.
    """
    beside = multiprocessing.get_context("spawn").Process(target=_compile, args=(config, rig), daemon=True)
    beside.start()
    try:
        yield
        with progress.start("tracker") as report:
            report(STATUS)
            beside.join()
    finally:
        beside.kill()


def _compile(config: TrackerConfig, rig: Rig) -> None:
    """Run the shipped tracker for a few scans of one car."""
    collect_rarely()
    with guarded(Tracker, config, phase="warm-up, ") as tracker:
        for index in range(FRAMES):
            scan = _car_ahead(index, rig)
            tracker.checked(tracker.step(scan), scan)


def _car_ahead(index: int, rig: Rig) -> Scan:
    """Return points on the rear and the left side of a car ahead, and on the ground, in all layers."""
    beams = beam_table(rig)
    rear, side = np.linspace(-0.9, 0.9, 25), np.linspace(0.0, 4.5, 40)
    x = np.concatenate([np.full(25, 8.0), 8.0 + side, np.linspace(3.0, 7.0, 20)]) + 0.5 * index
    y = np.concatenate([rear, np.full(40, 0.9), np.full(20, -4.0)])
    z = np.concatenate([np.full(65, 0.5), np.zeros(20)])
    points, layers = np.column_stack([x, y, z]), 4
    layer = np.repeat(np.arange(layers), len(points))
    made = Scan.from_points(0.08 * index, np.tile(points, (layers, 1)), layer=layer, echo_pulse_width=1.0)
    return Scan(
        made.time, made.ego_pose_odom, made.points_ego, made.time_offset, made.unit, made.layer, made.echo,
        made.echo_pulse_width, made.flags, sweep_limits(beams), beams.units.origin_ego[:, :2].copy(),
    )  # fmt: skip
