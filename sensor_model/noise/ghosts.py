"""Ghosts: objects seen by specular reflection in glass or paint of vehicles, behind the mirror."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from luxloop import elementwise
from luxloop.arrays import Floats, Ints
from luxloop.sensor_model.bodies.scene import Bodies
from luxloop.sensor_model.kernels.mirrors import bright_mirrors
from luxloop.sensor_model.kernels.records import BeamAxes, MovingPlanes, Reflectance, SurfaceHits, UnitPoses
from luxloop.sensor_model.noise.clutter_mixing import Clutter, point_width, unit_directions
from luxloop.sensor_model.returns import Returns
from luxloop.sensor_model.rig.beams import BeamTable
from luxloop.sensor_model.scan_context import ScanContext
from luxloop.sensor_model.truth import Cause, Part

GLASS_NORMAL_REFLECTANCE = 0.08
"""Reflectance of a pane at normal incidence: two faces of index 1.5, 0.04 each (Fresnel)."""
PAINT_NORMAL_REFLECTANCE = 0.04
"""Reflectance of the clear coat on paint at normal incidence: one face of index 1.5 (Fresnel)."""

_FAR_M = 1e6  # replaces infinity
_NORMAL_REFLECTANCE = np.zeros(len(Part))
_NORMAL_REFLECTANCE[Part.GREENHOUSE] = GLASS_NORMAL_REFLECTANCE
_NORMAL_REFLECTANCE[Part.BODY] = PAINT_NORMAL_REFLECTANCE


@dataclass(frozen=True, slots=True)
class Ghost:
    """Specular reflections in glass and paint of vehicles, strongest at grazing incidence."""

    enabled: bool = True
    """If false, no surface is a mirror."""
    glass_quality: float = 0.8
    """Share of the mirrored power that a pane leaves collimated, 0 to 1; curvature and dirt scatter the rest; an
    estimate."""
    paint_quality: float = 0.3
    """The same share for painted sheet metal, which is more curved; an estimate."""

    def __post_init__(self) -> None:
        for name in ("glass_quality", "paint_quality"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} = {getattr(self, name)}: must be from 0 (no mirror) to 1 (perfect mirror)")


@dataclass(frozen=True, slots=True, eq=False)
class Mirrored:
    """Hits of G mirrored rays."""

    range: Floats
    """(G,) range from the mirror, infinite without a hit [m]."""
    reflectivity: Floats
    """(G,) diffuse reflectivity."""
    cosine: Floats
    """(G,) cosine of the angle of incidence."""


Cast = Callable[[Ints, Floats, Floats, Floats], Mirrored]
"""Caster of rays from origins (G, 3) along directions (G, 3) in the ego frame, each at the firing time of its beam (G,)
and up to its reach (G,) [m]."""


class Mirrors:
    """Ghost generator of one run."""

    def __init__(self, config: Ghost, beams: BeamTable) -> None:
        self._beams = beams
        self._direction = unit_directions(beams)
        self._quality = np.zeros(len(Part))
        self._quality[Part.GREENHOUSE], self._quality[Part.BODY] = config.glass_quality, config.paint_quality

    def ghosts(self, returns: Returns, bodies: Bodies, context: ScanContext, time: Floats, cast: Cast) -> Clutter:
        """Return the ghosts of a frame.

        A beam is mirrored at r1 with the reflectance F and hits a surface of reflectivity rho at r2 from there, at the
        angle of incidence t. It returns on the same path with the power F^2 rho cos(t) gain / (r1 + r2)^2. The unit
        reports it on the straight line of the beam, at r1 + r2. F is that of Schlick (1994), F0 + (1 - F0) (1 - cos)^5,
        times the quality of the surface. Only the centre of a beam is followed, over one mirror, and only if the mirror
        returns an echo as well.

        Parameters
        ----------
        time
            (B,) true firing times relative to the frame's time [s].
        """
        row, ray = bright_mirrors(
            SurfaceHits(returns.beam, returns.range, returns.target, returns.surface, returns.part),
            MovingPlanes(bodies.pose_ego, bodies.yaw_rate, bodies.planes),
            Reflectance(_NORMAL_REFLECTANCE, self._quality),
            UnitPoses(context.origin_ego, context.R_ego_unit), context.drive,
            BeamAxes(self._beams.unit, self._beams.index, self._direction, time), self._beams.gain, context.threshold,
        )  # fmt: skip
        beam = returns.beam[row]
        # Beyond that, even a white surface at normal incidence is below the threshold.
        reach = ray[:, 6] * np.sqrt(self._beams.gain[beam] / context.threshold[beam]) - returns.range[row]
        met = cast(beam, ray[:, :3], ray[:, 3:6], reach)
        range_ = np.minimum(returns.range[row] + met.range, _FAR_M)
        power = ray[:, 6] ** 2 * met.reflectivity * met.cosine * self._beams.gain[beam] / range_**2
        power *= elementwise.exp(-2.0 * context.extinction * range_)
        seen = np.flatnonzero((power >= context.threshold[beam]) & (range_ < _FAR_M))
        return _clutter(beam[seen], range_[seen], power[seen], context, self._beams)


def _clutter(beam: Ints, range_: Floats, power: Floats, context: ScanContext, beams: BeamTable) -> Clutter:
    return Clutter(
        beam=beam,
        range=range_,
        width=point_width(beam, power, context.threshold, beams),
        power=power,
        part=np.full(len(beam), Part.NONE, dtype=np.uint8),
        cause=np.full(len(beam), Cause.GHOST, dtype=np.uint8),
        flags=np.zeros(len(beam), dtype=np.uint16),
    )
