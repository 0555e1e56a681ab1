"""Shapes with a defect each, beside sound ones."""

from __future__ import annotations

from typing import Any

import cadquery as cq
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_BSplineSurface
from OCP.Geom2d import Geom2d_Curve
from OCP.gp import gp_Pnt, gp_Vec2d
from OCP.TColgp import TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal
from OCP.TopoDS import TopoDS_Shell

BOX = (40.0, 30.0, 10.0)
DIAGONAL = sum(x * x for x in BOX) ** 0.5


def plate(height: float = BOX[2]) -> Any:
    """A plate with a bore and a hollow, from the origin on."""
    box = cq.Workplane().box(BOX[0], BOX[1], height, centered=False)
    bored = box.faces(">Z").workplane(origin=(10, 10, 0)).hole(6)
    return bored.faces(">Z").workplane(origin=(30, 20, 0)).hole(4, 3)


def shell_of(shape: Any, *, turn: int = -1, drop: int = -1, order: int = 1) -> Any:
    """The faces of a shape as a shell, one turned over, one left out, or all in another order."""
    shell, builder = TopoDS_Shell(), BRep_Builder()
    builder.MakeShell(shell)
    for number, face in list(enumerate(shape.faces().vals()))[::order]:
        if number != drop:
            builder.Add(shell, face.wrapped.Reversed() if number == turn else face.wrapped)
    return cq.Shell(shell)


def pair(
    names: tuple[str, str] = ("base", "peg"),
    colors: tuple[str, str] = ("red", "green"),
    places: tuple[float, float] = (0.0, 60.0),
    drop: bool = False,
) -> Any:
    """A plate and a peg."""
    assembly = cq.Assembly(name="pair")
    parts = plate(), cq.Workplane().cylinder(20, 4)
    for part, name, color, z in zip(parts, names, colors, places, strict=True):
        if not (drop and name == names[1]):
            assembly.add(part, name=name, color=cq.Color(color), loc=cq.Location(cq.Vector(5, 0, z)))
    return assembly


def four_pegs(*, drop: bool = False, shift: float = 0.0) -> Any:
    """One part placed four times, its places without names."""
    peg = cq.Workplane().cylinder(20, 4)
    assembly = cq.Assembly(name="pegs")
    for number in range(4 - drop):
        x = 20.0 * number + (shift if number == 1 else 0.0)
        assembly.add(peg, name=str(number + 1), loc=cq.Location(cq.Vector(x, 0, 0)))
    return assembly


def spline_face(knot: float = 0.5) -> Any:
    """A bumpy spline face with one inner knot in u."""
    poles = TColgp_Array2OfPnt(1, 5, 1, 4)
    for i in range(5):
        for j in range(4):
            poles.SetValue(i + 1, j + 1, gp_Pnt(10.0 * i, 10.0 * j, 6.0 * ((i * 2 + j) % 3)))
    us, um = TColStd_Array1OfReal(1, 3), TColStd_Array1OfInteger(1, 3)
    for i, (value, count) in enumerate(((0.0, 4), (knot, 1), (1.0, 4)), start=1):
        us.SetValue(i, value)
        um.SetValue(i, count)
    vs, vm = TColStd_Array1OfReal(1, 2), TColStd_Array1OfInteger(1, 2)
    for i, value in enumerate((0.0, 1.0), start=1):
        vs.SetValue(i, value)
        vm.SetValue(i, 4)
    surface = Geom_BSplineSurface(poles, us, vs, um, vm, 3, 3)
    return cq.Face(BRepBuilderAPI_MakeFace(surface, 1e-7).Face())


def degraded(shape: Any, shift: float) -> Any:
    """A copy in which the image of one edge on a cylinder is moved by so much (mm) along its axis."""
    copy = shape.val().copy()
    for face in copy.Faces():
        if face.geomType() != "CYLINDER":
            continue
        for edge in face.Edges():
            if edge.geomType() != "CIRCLE":
                continue
            curve = BRep_Tool.CurveOnSurface_s(edge.wrapped, face.wrapped, 0.0, 1.0)
            assert isinstance(curve, Geom2d_Curve)
            moved = curve.Translated(gp_Vec2d(0.0, shift))
            BRep_Builder().UpdateEdge(edge.wrapped, moved, face.wrapped, 2.0 * shift)
            return copy
    raise AssertionError("no circle on a cylinder")
