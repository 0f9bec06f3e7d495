"""Box trucks, articulated trucks and buses. The space beneath load bodies is open between wheels and frame."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from luxloop.sensor_model.bodies.materials import Glass
from luxloop.sensor_model.bodies.proportions.fitting_proportions import SPAN_END, Glazing
from luxloop.sensor_model.bodies.proportions.heavy_proportions import BusProportions, TruckProportions
from luxloop.sensor_model.bodies.shapes.cabin_shapes import Cabin, greenhouse
from luxloop.sensor_model.bodies.shapes.fitting_shapes import side_mirrors, wheels
from luxloop.sensor_model.bodies.solids import Plane, Solid, Vector, bevel, bowed, box, mirrored, prism, rounded
from luxloop.sensor_model.truth import Part
from luxloop.sim.articulation import AXLE_SPACING_M, WHEELBASE_M, Hitch, hitch
from luxloop.sim.world import Kind

_MIRROR_ROOT = 0.03
"""[m] Depth inside the side at which the mirrors' arms begin."""
_WHEEL_WIDTH, _TWIN_WIDTH = 0.32, 0.58
"""[m] Width of single and of twin wheels."""
_WHEEL_INSET = 0.02
"""[m] Inset of the tyres' outer faces."""
_FRAME = 0.43
"""[m] Half the standard width of a ladder frame, 0.86 m."""
_FRAME_DEPTH = 0.30
"""[m]"""
_GUARD_BOTTOM = 0.50
"""[m] Lower edges of side guards and underrun bar; at most 0.55 m by UN Regulations 73 and 58."""
_GUARD_INSET = 0.03
"""[m]"""
_BAND_INSET = 0.02
"""[m] Inset of a bus's windows from the sheet metal below."""
_GAP = 0.10
"""[m] Gap between cab and load body of a box truck."""
_TRAILER_GAP = 0.65
"""[m] Gap between cab and trailer, in which the trailer swings."""
_TAIL = 0.75
"""[m] Distance from a tractor's drive axle to the end of its frame."""

_END_TANGENTS = (-0.5, 0.5)
"""[m] Tangents of bowed ends from their middle, beside that in the middle."""


def truck(size: Vector, p: TruckProportions, glass: Glass) -> list[Solid]:
    """Make a box truck: cab, box on a frame, side guards, underrun bar, twin wheels in the rear."""
    length, width, height = size
    front, rear = length / 2, -length / 2
    box_front = front - p.cab - _GAP
    front_axle, rear_axle = front - p.front_overhang, rear + p.rear_overhang
    outer = width / 2 - _WHEEL_INSET
    return [
        *_cab(size, p, glass),
        _load_body(rear, box_front, width / 2, p.floor, height),
        _across(rear + 0.3, front - 0.5, _FRAME, p.floor - _FRAME_DEPTH, p.floor),
        _across(rear, rear + 0.1, width / 2 - 0.1, _GUARD_BOTTOM, _GUARD_BOTTOM + 0.12),
        *_side_guards(rear_axle + p.wheel_radius + 0.2, front_axle - p.wheel_radius - 0.3, width / 2, p.floor - 0.1),
        *side_mirrors(p.mirror, length, width / 2, _MIRROR_ROOT),
        *wheels(front_axle, p.wheel_radius, outer, _WHEEL_WIDTH),
        *wheels(rear_axle, p.wheel_radius, outer, _TWIN_WIDTH),
    ]


def trailer_truck(size: Vector, p: TruckProportions, glass: Glass) -> list[Solid]:
    """Make a two-axle tractor and, in line, a trailer with three axles and side guards in front of them.

    Their frames overlap from the trailer's front to the end of the tractor's frame.
    """
    length, width, height = size
    front, rear = length / 2, -length / 2
    outer = width / 2 - _WHEEL_INSET
    trailer_front = front - p.cab - _TRAILER_GAP
    drive_axle = front - p.front_overhang - WHEELBASE_M
    axles = [rear + p.rear_overhang + n * AXLE_SPACING_M for n in range(3)]
    frame = (_FRAME, p.floor - _FRAME_DEPTH, p.floor)
    tractor = [
        *_cab(size, p, glass),
        _across(drive_axle - _TAIL, front - 0.8, *frame),
        *side_mirrors(p.mirror, length, width / 2, _MIRROR_ROOT),
        *wheels(front - p.front_overhang, p.wheel_radius, outer, _WHEEL_WIDTH),
        *wheels(drive_axle, p.wheel_radius, outer, _TWIN_WIDTH),
    ]
    trailer = [
        _load_body(rear, trailer_front, width / 2, p.floor, height),
        _across(rear + 0.3, trailer_front, *frame),
        _across(rear, rear + 0.1, width / 2 - 0.1, _GUARD_BOTTOM, _GUARD_BOTTOM + 0.12),
        *_side_guards(axles[-1] + p.wheel_radius + 0.2, drive_axle - p.wheel_radius - 0.3, width / 2, p.floor - 0.2),
        *(wheel for axle in axles for wheel in wheels(axle, p.wheel_radius, outer, _WHEEL_WIDTH)),
    ]
    return [*(replace(solid, ahead=1) for solid in tractor), *trailer]


def bus(size: Vector, p: BusProportions, glass: Glass) -> list[Solid]:
    """Make a bus: sheet metal up to the beltline, a band of windows, a roof, and a closed rear."""
    length, width, height = size
    front, rear = length / 2, -length / 2
    belt, outer = p.belt, width / 2 - _WHEEL_INSET
    lower = prism(
        Part.BODY,
        [
            (rear + 0.2, p.clearance),
            (front - 0.1, p.clearance),
            (front, 0.45),
            (front, belt),
            (rear, belt),
            (rear, 0.45),
        ],
        width / 2,
    )
    curves = [
        *bowed(lower.planes[2], p.front_bow, SPAN_END, _END_TANGENTS),
        *bowed(lower.planes[4], p.rear_bow, SPAN_END, _END_TANGENTS),
        *rounded(Part.BODY, front - p.front_bow, width / 2, p.radius),
        *rounded(Part.BODY, rear + p.rear_bow, width / 2, p.radius),
    ]
    glazing = Glazing(
        windscreen_deg=p.windscreen_deg,
        backlight_deg=88.0,
        tumblehome_deg=1.0,
        shoulder=_BAND_INSET,
        front_pillar=0.12,
        rear_pillar=0.20,
        frame=0.25,
    )
    band = Cabin(
        (rear + _BAND_INSET, belt), (front - _BAND_INSET, belt), width / 2 - _BAND_INSET, height, Part.BODY,
        front_bow=p.front_bow, rear_bow=p.rear_bow,
    )  # fmt: skip
    return [
        lower.cut(curves).pruned(),
        *greenhouse(band, glazing, glass, pillars=((0.10, 0.15), (0.55, 0.15))),
        *side_mirrors(p.mirror, length, width / 2, _MIRROR_ROOT + _BAND_INSET),
        *wheels(front - p.front_overhang, p.wheel_radius, outer, _WHEEL_WIDTH),
        *wheels(rear + p.rear_overhang, p.wheel_radius, outer, _TWIN_WIDTH),
    ]


def articulated_bus(size: Vector, p: BusProportions, glass: Glass) -> list[Solid]:
    """Make a bus with a joint: front and rear part meet at a plane through it, where the bellows are closed."""
    middle = size[0] / 2 - float(_bus_hitch(size[0]).drive_axle[0])
    solids = [*bus(size, p, glass), *wheels(middle, p.wheel_radius, size[1] / 2 - _WHEEL_INSET, _TWIN_WIDTH)]
    return divided(solids, [bus_joint(size[0])])


def bus_joint(length: float) -> float:
    """Return x of the joint of an articulated bus [m]."""
    return length / 2 - float(_bus_hitch(length).kingpin[0])


def divided(solids: list[Solid], joints: list[float]) -> list[Solid]:
    """Divide solids by the planes x = `joints` [m], from the front; the parts between two belong to one section."""
    middle = (len(joints) + 1) // 2
    parts = []
    for solid in map(Solid.pruned, solids):
        for section, (front, rear) in enumerate(pairwise([math.inf, *joints, -math.inf])):
            cuts = []
            if solid.low[0] < rear < solid.high[0]:
                cuts.append(Plane((-1.0, 0.0, 0.0), -rear, Part.BODY))
            if solid.low[0] < front < solid.high[0]:
                cuts.append(Plane((1.0, 0.0, 0.0), front, Part.BODY))
            if solid.high[0] > rear and solid.low[0] < front:
                part = solid.cut(cuts).pruned() if cuts else solid
                parts.append(replace(part, ahead=middle - section))
    return parts


def _bus_hitch(length: float) -> Hitch:
    return hitch(np.array([length]), np.array([Kind.BUS], np.uint8))


def _side_guards(rear: float, front: float, side: float, top: float) -> list[Solid]:
    """Make a plate between the axles on each side, as required by UN Regulation 73 for trucks and trailers."""
    guard = box(Part.BODY, (rear, front), (side - _GUARD_INSET - 0.05, side - _GUARD_INSET), (_GUARD_BOTTOM, top))
    return [guard, mirrored(guard)]


def _cab(size: Vector, p: TruckProportions, glass: Glass) -> list[Solid]:
    """Make a cab over engine: lower part with the bumper, and a glazed upper part with a closed rear wall."""
    length, width, height = size
    front, back = length / 2, length / 2 - p.cab
    half_width = width / 2 - 0.01
    roof = p.cab_share * height
    belt = min(1.45, 0.62 * roof)
    lower = prism(
        Part.BODY,
        [
            (back, p.clearance),
            (front - 0.1, p.clearance),
            (front, 0.42),
            (front, 0.9),
            (front - 0.06, belt),
            (back, belt),
        ],
        half_width,
    )
    glazing = Glazing(
        windscreen_deg=p.windscreen_deg,
        backlight_deg=90.0,
        tumblehome_deg=2.0,
        shoulder=0.0,
        front_pillar=0.16,
        rear_pillar=0.10,
        frame=0.20,
    )
    bow = p.front_bow
    curves = [facet for plane in lower.planes[2:4] for facet in bowed(plane, bow, SPAN_END, _END_TANGENTS)]
    corners = rounded(Part.BODY, front - bow, half_width, p.radius)
    upper = Cabin((back, belt), (front - 0.07, belt), half_width - 0.01, roof, Part.BODY, front_bow=bow)
    # The pillar is the sheet metal behind the doors.
    return [lower.cut([*curves, *corners]).pruned(), *greenhouse(upper, glazing, glass, ((0.8, 0.3 * p.cab),))]


def _load_body(rear: float, front: float, half_width: float, floor: float, top: float) -> Solid:
    body = _across(rear, front, half_width, floor, top)
    left, right, roof = body.planes[2], body.planes[3], body.planes[5]
    return body.cut(bevel(Part.BODY, side, roof, 0.08) for side in (left, right))


def _across(rear: float, front: float, half_width: float, bottom: float, top: float) -> Solid:
    """Make a box symmetric about the middle of the vehicle."""
    return box(Part.BODY, (rear, front), (-half_width, half_width), (bottom, top))
