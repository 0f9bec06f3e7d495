"""The glazed upper part of vehicles: curved panes, sheet metal around them, pillars and interior."""

from dataclasses import dataclass

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions.fitting_proportions import SPAN_END, SPAN_SIDE, Glazing
from luxloop.sensor_model.bodies.solids import Plane, Solid, bevel, bowed, level, moved, sides, slope, x_at
from luxloop.sensor_model.truth import Part

_PROUD = 0.004
"""[m] Protrusion of pillars from the panes."""
_HEADROOM = 0.15
"""[m] Gap between the roof and the tops of seats and heads."""
_SUNK = 0.03
"""[m] Overlap of the glazed part with the body, which closes the gap."""
_LINING = 0.10
"""[m] Gap between the interior's walls, or the edge of a shelf, and the panes."""
_END_TANGENTS, _SIDE_TANGENTS = (-0.5, 0.5), (-0.9, 0.9)
"""[m] Tangents of curved panes from the middle of the vehicle, beside that in the middle."""


@dataclass(frozen=True, slots=True)
class Cabin:
    """Outline of the glazed part of a vehicle. Lengths and heights [m]."""

    rear_foot: tuple[float, float]
    """x, z of the foot of the rear window."""
    front_foot: tuple[float, float]
    """x, z of the foot of the windscreen, which is at the beltline."""
    half_width: float
    """Half width at the beltline, in the middle of the vehicle."""
    roof: float
    rear: Part = Part.GREENHOUSE
    """Material of the rear window."""
    front_bow: float = 0.0
    rear_bow: float = 0.0
    """Sagitta of horizontal sections over 0.75 m to either side of the middle."""
    side_bow: float = 0.0
    """The same over 1.6 m."""


@dataclass(frozen=True, slots=True)
class _Panes:
    """Planes of the four panes. The first one of each is the tangent in the middle."""

    front: list[Plane]
    back: list[Plane]
    left: list[Plane]
    right: list[Plane]

    @property
    def all(self) -> list[Plane]:
        return [*self.front, *self.back, *self.left, *self.right]


def greenhouse(
    cabin: Cabin, glazing: Glazing, glass: Glass, pillars: tuple[tuple[float, float], ...] = ()
) -> list[Solid]:
    """Make the glazed part of a vehicle, its interior, and its pillars.

    Roof, corner pillars, headers and rails are sheet metal: facets between the panes.

    Parameters
    ----------
    pillars
        Pillars between two side windows: position along the roof, 0 at its front edge to 1 at its rear edge, and width
        along the vehicle [m].
    """
    panes, belt = _panes(cabin, glazing), cabin.front_foot[1]
    top, floor = level(Part.BODY, cabin.roof), level(Part.BODY, belt - _SUNK, up=False)
    posts = [
        bevel(Part.BODY, _outermost(end, y, 1), _outermost(side, x, 0), width)
        for end, x, width in ((panes.front, 1.0, glazing.front_pillar), (panes.back, -1.0, glazing.rear_pillar))
        for side, y in ((panes.left, 1.0), (panes.right, -1.0))
    ]
    frame = [
        bevel(Part.BODY, pane[0], top, glazing.frame) for pane in (panes.front, panes.back, panes.left, panes.right)
    ]
    low = (x_at(panes.back[0], belt - _SUNK), -cabin.half_width - _SUNK, belt - _SUNK)
    high = (x_at(panes.front[0], belt - _SUNK), cabin.half_width + _SUNK, cabin.roof)
    outside = Solid((*panes.all, top, floor, *posts, *frame), low, high)
    inside = _interior(panes, top, floor, glass.interior_depth_m, belt, outside)
    return [outside.pruned(), *inside, *(_pillar(panes, frame[2], top, floor, *pillar, outside) for pillar in pillars)]


def _panes(cabin: Cabin, glazing: Glazing) -> _Panes:
    pane, belt = Part.GREENHOUSE, cabin.front_foot[1]
    front = slope(pane, *cabin.front_foot, glazing.windscreen_deg)
    back = slope(cabin.rear, *cabin.rear_foot, -glazing.backlight_deg)
    left, right = sides(pane, cabin.half_width, belt, glazing.tumblehome_deg)
    return _Panes(
        _curved(front, cabin.front_bow, SPAN_END, _END_TANGENTS),
        _curved(back, cabin.rear_bow, SPAN_END, _END_TANGENTS),
        _curved(left, cabin.side_bow, SPAN_SIDE, _SIDE_TANGENTS),
        _curved(right, cabin.side_bow, SPAN_SIDE, _SIDE_TANGENTS),
    )


def _curved(pane: Plane, bow: float, half_span: float, tangents: tuple[float, ...]) -> list[Plane]:
    return [pane, *(bowed(pane, bow, half_span, tangents) if bow > 0.0 else [])]


def _outermost(pane: list[Plane], sign: float, axis: int) -> Plane:
    """Return the plane of a pane that faces most along an axis."""
    return max(pane, key=lambda plane: sign * plane.normal[axis])


def _pillar(panes: _Panes, rail: Plane, top: Plane, floor: Plane, share: float, width: float, outside: Solid) -> Solid:
    """Make the pillars between two side windows: a slice of the greenhouse, a few millimetres wider."""
    ahead, behind = x_at(panes.front[0], top.offset), x_at(panes.back[0], top.offset)
    x = ahead + share * (behind - ahead)
    # Height at which the side windows end under the rail.
    (_, y, z), offset = panes.left[0].normal, panes.left[0].offset
    z_end = (rail.offset * y - offset * rail.normal[1]) / (rail.normal[2] * y - z * rail.normal[1])
    low, high = (x - width / 2, outside.low[1], outside.low[2]), (x + width / 2, outside.high[1], z_end)
    flats = [
        Plane((1.0, 0.0, 0.0), high[0], Part.BODY),
        Plane((-1.0, 0.0, 0.0), -low[0], Part.BODY),
        level(Part.BODY, z_end),
        moved(floor, 0.0, Part.BODY),
        *(moved(plane, _PROUD, Part.BODY) for plane in (*panes.left, *panes.right)),
    ]
    return Solid(tuple(flats), low, high).pruned()


def _interior(panes: _Panes, top: Plane, floor: Plane, depth: float, belt: float, outside: Solid) -> list[Solid]:
    """Make seats and heads behind the panes, and dashboard and parcel shelf at the height of the beltline."""
    part = Part.INTERIOR
    behind_back = depth if panes.back[0].part is Part.GREENHOUSE else _LINING
    seats = [
        *(moved(plane, -depth * abs(panes.front[0].normal[0]), part) for plane in panes.front),
        *(moved(plane, -behind_back * abs(panes.back[0].normal[0]), part) for plane in panes.back),
        *(moved(plane, -0.5 * depth * abs(plane.normal[1]), part) for plane in (*panes.left, *panes.right)),
        moved(top, -_HEADROOM, part),
        moved(floor, 0.0, part),
    ]
    shelf = [
        *(moved(plane, -_LINING, part) for plane in panes.all),
        level(part, belt - _SUNK / 3),
        moved(floor, 0.0, part),
    ]
    return [Solid(tuple(planes), outside.low, outside.high, inner=True).pruned() for planes in (seats, shelf)]
