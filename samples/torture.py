"""Models made to be hard: poles, seams, apexes, tangency, extreme sizes and places."""

from __future__ import annotations

import math
from collections.abc import Callable

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_NurbsConvert
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeOffsetShape
from OCP.Geom import Geom_OffsetSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Torus


def sphere() -> cq.Workplane:
    return cq.Workplane("XY").sphere(10)


def cylinder() -> cq.Workplane:
    return cq.Workplane("XY").circle(10).extrude(25)


def cone_apex() -> cq.Shape:
    return cq.Solid.makeCone(10, 0, 20)


def torus() -> cq.Shape:
    return cq.Solid.makeTorus(20, 6)


def horn_torus() -> cq.Shape:
    """Major radius = minor radius: the surface touches itself in its centre."""
    face = BRepBuilderAPI_MakeFace(gp_Torus(gp_Ax3(gp_Pnt(), gp_Dir(0, 0, 1)), 10, 10)).Face()
    return cq.Face(face)


def nurbs_solids() -> cq.Shape:
    """Sphere, cylinder, cone and torus as rational B-splines."""
    solids = [
        cq.Solid.makeSphere(8, cq.Vector(0, 0, 0)),
        cq.Solid.makeCylinder(6, 16, cq.Vector(20, 0, -8)),
        cq.Solid.makeCone(8, 0, 16, cq.Vector(40, 0, -8)),
        cq.Solid.makeTorus(8, 3, cq.Vector(64, 0, 0)),
    ]
    compound = cq.Compound.makeCompound(solids)
    return cq.Shape.cast(BRepBuilderAPI_NurbsConvert(compound.wrapped, True).Shape())


def hole_on_seam() -> cq.Workplane:
    """A cross hole that is cut right through the seam of the cylinder (x > 0, y = 0)."""
    return cylinder().cut(cq.Workplane("YZ").center(0, 12).circle(4).extrude(30))


def hole_touches_seam() -> cq.Workplane:
    """A cross hole whose rim touches the seam in one point."""
    hole = cq.Workplane("YZ").center(3, 12).circle(3).extrude(30)
    return cylinder().cut(hole)


def pole_cut() -> cq.Workplane:
    """A sphere with a bore beside its pole and one right through both poles."""
    part = sphere().cut(cq.Workplane("XY").circle(2).extrude(40, both=True))
    return part.cut(cq.Workplane("XY").center(4, 0).circle(1.5).extrude(40))


def tangent_contacts() -> cq.Shape:
    """Solids that touch in a point, along a line, and in a face."""
    return cq.Compound.makeCompound(
        [
            cq.Solid.makeSphere(5, cq.Vector(0, 0, 5)),
            cq.Solid.makeBox(30, 10, 2, cq.Vector(-5, -5, -2)),
            cq.Solid.makeCylinder(4, 10, cq.Vector(12, -5, 4), cq.Vector(0, 1, 0)),
            cq.Solid.makeBox(5, 5, 5, cq.Vector(18, -2, 0)),
        ]
    )


def thin_fillets() -> cq.Workplane:
    """Fillets of 1 % of the size, tangent everywhere."""
    return cq.Workplane("XY").box(20, 15, 10).edges().fillet(0.2)


def slots() -> cq.Workplane:
    """True slots of 0.01 mm: gaps that must stay open."""
    part = cq.Workplane("XY").box(20, 20, 5)
    for k in range(5):
        part = part.cut(cq.Workplane("XY").box(0.01, 14, 10).translate((-8 + 4 * k, 0, 0)))
    return part


def tiny() -> cq.Workplane:
    """A part of 10 micrometres."""
    return cq.Workplane("XY").box(0.01, 0.008, 0.006).faces(">Z").hole(0.004)


def huge() -> cq.Workplane:
    """A part of 2 km."""
    return cq.Workplane("XY").box(2e6, 1e6, 5e5).faces(">Z").hole(6e5).edges("|Z").fillet(5e4)


def far_away() -> cq.Workplane:
    """A 20 mm part 100 m off the origin."""
    part = cq.Workplane("XY").box(20, 15, 10).edges("|Z").fillet(3).faces(">Z").hole(6)
    return part.translate((1e5, -1e5, 1e5))


def revolved_spline() -> cq.Workplane:
    """A spline turned about an axis that it starts on: a surface of revolution with a pole."""
    profile = cq.Workplane("XZ").moveTo(0, 0).spline([(6, 2), (9, 8), (4, 14), (6, 20)], includeCurrent=True)
    return profile.lineTo(0, 20).close().revolve(360, (0, 0, 0), (0, 1, 0))


def extruded_spline() -> cq.Workplane:
    points = [(10, 0), (4, 6), (-6, 9), (-9, -2), (0, -8)]
    return cq.Workplane("XY").spline(points, periodic=True).close().extrude(6)


def offset_surface() -> cq.Shape:
    """A free-form face moved 1.5 mm along its normal: it has no exact NURBS form."""
    from freeform import free_patch

    surface = free_patch().Faces()[0]._geomAdaptor()
    return cq.Face(BRepBuilderAPI_MakeFace(Geom_OffsetSurface(surface, 1.5), 1e-7).Face())


def thick_shell() -> cq.Shape:
    """A closed solid whose inner wall is an offset of a spline surface."""
    blob = extruded_spline()
    make = BRepOffsetAPI_MakeOffsetShape()
    make.PerformByJoin(blob.val().wrapped, -1.0, 1e-4)
    return cq.Compound.makeCompound([blob.val(), cq.Shape.cast(make.Shape())])


def helix_thread() -> cq.Workplane:
    """A swept thread: long thin spline faces with many spans."""
    helix = cq.Wire.makeHelix(2, 8, 5)
    profile = cq.Workplane("XZ").center(5, 0).polyline([(-0.3, -0.6), (0.7, 0), (-0.3, 0.6)]).close()
    return profile.sweep(cq.Workplane(obj=helix), isFrenet=True)


def ellipse_cone() -> cq.Workplane:
    """A loft from an ellipse to a point-like circle: nearly collapsed side."""
    return cq.Workplane("XY").ellipse(10, 6).workplane(offset=20).circle(1e-3).loft()


def half_cylinders() -> cq.Workplane:
    """Faces trimmed exactly along u = 0 and u = pi."""
    part = cq.Workplane("XY").circle(10).extrude(10)
    return part.cut(cq.Workplane("XY").box(40, 20, 40).translate((0, 10, 0)))


def many_holes() -> cq.Workplane:
    """A disc with 60 holes: long trim loops on two planes."""
    part = cq.Workplane("XY").circle(40).extrude(3)
    rings = [(r, n) for r, n in ((10, 8), (20, 20), (32, 32))]
    points = [
        (r * math.cos(2 * math.pi * k / n), r * math.sin(2 * math.pi * k / n))
        for r, n in rings
        for k in range(n)
    ]
    return part.faces(">Z").workplane().pushPoints(points).hole(3)


TORTURE: dict[str, Callable[[], cq.Workplane | cq.Shape]] = {
    f.__name__: f
    for f in (
        sphere, cylinder, cone_apex, torus, horn_torus, nurbs_solids, hole_on_seam,
        hole_touches_seam, pole_cut, tangent_contacts, thin_fillets, slots, tiny, huge, far_away,
        revolved_spline, extruded_spline, offset_surface, thick_shell, helix_thread, ellipse_cone,
        half_cylinders, many_holes,
    )
}  # fmt: skip
