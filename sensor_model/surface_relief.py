"""Displacement of echoes by the relief of the surfaces they are on."""

from dataclasses import replace

from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.kernels.records import RoughPlanes
from luxloop.sensor_model.kernels.relief_shift import shift_to_relief
from luxloop.sensor_model.raycaster import Echoes


def displace(echoes: Echoes, bodies: Bodies, scale: float) -> Echoes:
    """Return the echoes moved to the relief of their surfaces.

    Parameters
    ----------
    echoes
        Echoes of the solids.
    scale
        Factor of the heights; 0 returns the echoes unchanged.
    """
    if scale == 0.0:
        return echoes
    ranges, points = echoes.range.copy(), echoes.point_body.copy()
    rough = RoughPlanes(
        bodies.planes_body, bodies.plane_turn, bodies.plane_relief, bodies.plane_pivot, bodies.relief_waves
    )
    shift_to_relief(echoes.target, echoes.surface, echoes.direction_body, rough, scale, ranges, points)
    return replace(echoes, range=ranges, point_body=points)
