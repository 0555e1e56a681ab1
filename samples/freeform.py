"""Samples made of free-form surfaces, the scenes of the hybrid ray tracing paper among them."""

from __future__ import annotations

import math

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_BezierSurface, Geom_BSplineSurface
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal, TColStd_Array2OfReal
from teapot_patches import PATCHES, VERTICES

Point = tuple[float, float, float]


def _poles(rows: list[list[Point]], scale: float = 1.0) -> TColgp_Array2OfPnt:
    array = TColgp_Array2OfPnt(1, len(rows), 1, len(rows[0]))
    for i, row in enumerate(rows, 1):
        for j, (x, y, z) in enumerate(row, 1):
            array.SetValue(i, j, gp_Pnt(scale * x, scale * y, scale * z))
    return array


def bezier_face(rows: list[list[Point]], scale: float = 1.0) -> cq.Face:
    """An untrimmed Bezier patch; rows run in u."""
    return cq.Face(BRepBuilderAPI_MakeFace(Geom_BezierSurface(_poles(rows, scale)), 1e-7).Face())


def bspline_face(
    rows: list[list[Point]],
    weights: list[list[float]],
    knots: tuple[list[float], list[float]],
    multiplicities: tuple[list[int], list[int]],
    degrees: tuple[int, int],
) -> cq.Face:
    """An untrimmed rational B-spline surface; knots are distinct values."""
    w = TColStd_Array2OfReal(1, len(rows), 1, len(rows[0]))
    for i, row in enumerate(weights, 1):
        for j, value in enumerate(row, 1):
            w.SetValue(i, j, value)
    k = [TColStd_Array1OfReal(1, len(values)) for values in knots]
    m = [TColStd_Array1OfInteger(1, len(values)) for values in multiplicities]
    for array, values in [*zip(k, knots, strict=True), *zip(m, multiplicities, strict=True)]:
        for i, value in enumerate(values, 1):
            array.SetValue(i, value)
    surface = Geom_BSplineSurface(_poles(rows), w, k[0], k[1], m[0], m[1], *degrees)
    return cq.Face(BRepBuilderAPI_MakeFace(surface, 1e-7).Face())


def free_patch() -> cq.Shape:
    """One bicubic rational patch with waves and weights from 0.4 to 3."""
    n = 7
    rows = [
        [(10.0 * i, 10.0 * j, 9.0 * math.sin(1.1 * i) * math.cos(0.9 * j)) for j in range(n)]
        for i in range(n)
    ]
    weights = [[1.0 + 0.6 * math.sin(i + 2 * j) for j in range(n)] for i in range(n)]
    weights[3][3], weights[2][4] = 3.0, 0.4
    knots, mults = [0.0, 0.2, 0.5, 0.8, 1.0], [4, 1, 1, 1, 4]
    return bspline_face(rows, weights, (knots, knots), (mults, mults), (3, 3))


def _loft(inset: float) -> cq.Workplane:
    """A duct from a rectangle through an ellipse to a circle, `inset` mm smaller all round."""
    duct = cq.Workplane("XY").rect(40 - 2 * inset, 24 - 2 * inset)
    duct = duct.workplane(offset=30).center(6, 0).ellipse(15 - inset, 11 - inset)
    return duct.workplane(offset=30).center(8, 0).circle(9 - inset).loft(ruled=False)


def spline_part() -> cq.Workplane:
    """A lofted, shelled duct with a spline flange and a trimmed window: B-splines beside planes."""
    duct = _loft(0).cut(_loft(2))
    outline = [(30, 0), (22, 18), (0, 24), (-24, 20), (-30, 0), (-20, -22), (4, -24), (24, -16)]
    flange = cq.Workplane("XY").spline(outline, periodic=True).close().extrude(-5)
    flange = flange.cut(cq.Workplane("XY").rect(36, 20).extrude(-5))
    part = duct.union(flange)
    window = cq.Workplane("XZ").center(6, 30).ellipse(5, 8).extrude(-40)
    return part.cut(window)


def teapot() -> cq.Shape:
    """The Utah teapot as it was published: 32 untrimmed bicubic Bezier patches, in mm times 10."""
    return cq.Compound.makeCompound(
        [
            bezier_face([[VERTICES[p[4 * i + j]] for j in range(4)] for i in range(4)], scale=10.0)
            for p in PATCHES
        ]
    )


def _quad(a: Point, b: Point, c: Point, d: Point) -> cq.Face:
    """A bilinear patch through four corners in order; its normal is (b - a) x (d - a)."""
    return bezier_face([[a, d], [b, c]])


def _block(corners: list[tuple[float, float]], height: float) -> list[cq.Face]:
    """The top and four sides of a block that stands on the floor (y = 0)."""
    top = [(x, height, z) for x, z in corners]
    low = [(x, 0.0, z) for x, z in corners]
    sides = [_quad(low[k - 1], low[k], top[k], top[k - 1]) for k in range(4)]
    return [_quad(top[0], top[1], top[2], top[3]), *sides]


def cornell_box() -> cq.Assembly:
    """The Cornell box, from the published measurements (mm), as 18 patches.

    Five walls, the light, the short block and the tall block (five patches each), and two low
    bilinear sills that bring the count to the paper's 18.
    """
    x, y, z = 552.8, 548.8, 559.2
    white, red, green = (
        cq.Color(0.9, 0.88, 0.82),
        cq.Color(0.7, 0.1, 0.08),
        cq.Color(0.15, 0.5, 0.1),
    )
    walls = {
        "floor": (_quad((x, 0, 0), (0, 0, 0), (0, 0, z), (549.6, 0, z)), white),
        "ceiling": (_quad((556, y, 0), (556, y, z), (0, y, z), (0, y, 0)), white),
        "back": (_quad((549.6, 0, z), (0, 0, z), (0, y, z), (556, y, z)), white),
        "right": (_quad((0, 0, z), (0, 0, 0), (0, y, 0), (0, y, z)), green),
        "left": (_quad((x, 0, 0), (549.6, 0, z), (556, y, z), (556, y, 0)), red),
        "light": (
            _quad((343, 548.7, 227), (343, 548.7, 332), (213, 548.7, 332), (213, 548.7, 227)),
            cq.Color(1.0, 0.95, 0.75),
        ),
        "sill_left": (_quad((x, 0.0, 540), (x, 20, 559), (0, 20, 559), (0, 0.0, 540)), white),
        "sill_top": (_quad((0, 548, 530), (0, 520, 559), (556, 520, 559), (556, 548, 530)), white),
    }
    box = cq.Assembly(name="cornell_box")
    for name, (face, color) in walls.items():
        box.add(face, name=name, color=color)
    short = _block([(130, 65), (82, 225), (240, 272), (290, 114)], 165)
    tall = _block([(423, 247), (265, 296), (314, 456), (472, 406)], 330)
    for name, faces in (("short", short), ("tall", tall)):
        for k, face in enumerate(faces):
            box.add(face, name=f"{name}{k}", color=white)
    return box
