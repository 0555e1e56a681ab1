"""Writes the small B-rep streams in data/ that the C++ tests read.

Run with cadquery's OCP: python tests/core/brep/make_streams.py. The tests know every number below, so
a change here needs a change there. The streams are committed, so that C++ tests need no Python.
"""

import io
import math
from pathlib import Path

from OCP.BinTools import BinTools_ShapeSet
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepLib import BRepLib
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.Geom import (
    Geom_BezierCurve,
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_Line,
    Geom_OffsetCurve,
    Geom_OffsetSurface,
    Geom_Parabola,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import (
    Geom2d_BezierCurve,
    Geom2d_BSplineCurve,
    Geom2d_Circle,
    Geom2d_Ellipse,
    Geom2d_Hyperbola,
    Geom2d_Line,
    Geom2d_OffsetCurve,
    Geom2d_Parabola,
    Geom2d_TrimmedCurve,
)
from OCP.gp import (
    gp_Ax1,
    gp_Ax2,
    gp_Ax2d,
    gp_Ax3,
    gp_Ax22d,
    gp_Dir,
    gp_Dir2d,
    gp_Pnt,
    gp_Pnt2d,
    gp_Trsf,
    gp_Vec,
)
from OCP.Poly import Poly_Polygon3D, Poly_Triangle, Poly_Triangulation
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d, TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal, TColStd_Array2OfReal
from OCP.TopAbs import TopAbs_INTERNAL, TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Edge, TopoDS_Face, TopoDS_Shape, TopoDS_Vertex

DATA = Path(__file__).parent / "data"
BUILDER = BRep_Builder()
ALL = TopAbs_ShapeEnum


def write(name: str, shape: TopoDS_Shape, *, version: int = 4, meshes: bool = False) -> None:
    shapes = BinTools_ShapeSet()
    shapes.SetFormatNb(version)
    shapes.SetWithTriangles(meshes)
    shapes.SetWithNormals(meshes)
    shapes.Add(shape)
    stream = io.BytesIO()
    shapes.Write(stream)
    (DATA / f"{name}.bin").write_bytes(stream.getvalue())


def compound(shapes: list) -> TopoDS_Compound:
    result = TopoDS_Compound()
    BUILDER.MakeCompound(result)
    for shape in shapes:
        BUILDER.Add(result, shape)
    return result


def reals(values: list[float]) -> TColStd_Array1OfReal:
    array = TColStd_Array1OfReal(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, value)
    return array


def integers(values: list[int]) -> TColStd_Array1OfInteger:
    array = TColStd_Array1OfInteger(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, value)
    return array


def points(values: list[tuple[float, float, float]]) -> TColgp_Array1OfPnt:
    array = TColgp_Array1OfPnt(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, gp_Pnt(*value))
    return array


def points2(values: list[tuple[float, float]]) -> TColgp_Array1OfPnt2d:
    array = TColgp_Array1OfPnt2d(1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, gp_Pnt2d(*value))
    return array


def pole_grid(count_u: int, count_v: int) -> TColgp_Array2OfPnt:
    """Pole (i, j), counted from 0, is (i, j, 10 i + j)."""
    array = TColgp_Array2OfPnt(1, count_u, 1, count_v)
    for i in range(count_u):
        for j in range(count_v):
            array.SetValue(i + 1, j + 1, gp_Pnt(i, j, 10 * i + j))
    return array


def weight_grid(count_u: int, count_v: int) -> TColStd_Array2OfReal:
    """Weight (i, j), counted from 0, is 1 + i + j / 8."""
    array = TColStd_Array2OfReal(1, count_u, 1, count_v)
    for i in range(count_u):
        for j in range(count_v):
            array.SetValue(i + 1, j + 1, 1 + i + j / 8)
    return array


def curves3() -> None:
    """Edge k has the 3D curve of kind k; then a periodic rational spline and an offset of a trim."""
    frame = gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(0, 0, 1), gp_Dir(0, 1, 0))
    four = [(0, 0, 0), (1, 2, 0), (3, 2, 1), (4, 0, 2)]
    spline = Geom_BSplineCurve(points(four), reals([0, 0.5, 2]), integers([3, 1, 3]), 2)
    circle = Geom_Circle(frame, 2.5)
    curves = [
        Geom_Line(gp_Pnt(1, 2, 3), gp_Dir(0, 0, -1)),
        circle,
        Geom_Ellipse(frame, 5, 3),
        Geom_Parabola(frame, 0.75),
        Geom_Hyperbola(frame, 4, 6),
        Geom_BezierCurve(points(four), reals([1, 0.5, 0.25, 2])),
        spline,
        Geom_TrimmedCurve(circle, 0.25, 1.5),
        Geom_OffsetCurve(spline, 0.125, gp_Dir(0, 0, 1)),
        Geom_BSplineCurve(
            points(four), reals([1, 2, 3, 4]), reals([0, 1, 2, 3, 4]), integers([1, 1, 1, 1, 1]), 3, True
        ),
        Geom_OffsetCurve(Geom_TrimmedCurve(spline, 0.5, 1.0), -1, gp_Dir(1, 0, 0)),
    ]
    edges = []
    for i, curve in enumerate(curves):
        edge = TopoDS_Edge()
        BUILDER.MakeEdge(edge, curve, 0.001 * (i + 1))
        BUILDER.Range(edge, 0.5, 0.75 + i)
        edges.append(edge)
    write("curves3", compound(edges))


def curves2() -> None:
    """The single edge has one p-curve of each kind, each on a plane of its own (z = k)."""
    frame = gp_Ax22d(gp_Pnt2d(1, 2), gp_Dir2d(0, 1), gp_Dir2d(1, 0))  # left-handed
    four = [(0, 0), (1, 2), (3, 2), (4, 0)]
    spline = Geom2d_BSplineCurve(points2(four), reals([0, 0.5, 2]), integers([3, 1, 3]), 2)
    circle = Geom2d_Circle(frame, 2.5)
    curves = [
        Geom2d_Line(gp_Pnt2d(1, 2), gp_Dir2d(0, -1)),
        circle,
        Geom2d_Ellipse(frame, 5, 3),
        Geom2d_Parabola(frame, 0.75),
        Geom2d_Hyperbola(frame, 4, 6),
        Geom2d_BezierCurve(points2(four), reals([1, 0.5, 0.25, 2])),
        spline,
        Geom2d_TrimmedCurve(circle, 0.25, 1.5),
        Geom2d_OffsetCurve(spline, 0.125),
        Geom2d_BSplineCurve(
            points2(four), reals([1, 2, 3, 4]), reals([0, 1, 2, 3, 4]), integers([1, 1, 1, 1, 1]), 3, True
        ),
    ]
    edge = TopoDS_Edge()
    BUILDER.MakeEdge(edge)
    for i, curve in enumerate(curves):
        plane = Geom_Plane(gp_Pnt(0, 0, i), gp_Dir(0, 0, 1))
        BUILDER.UpdateEdge(edge, curve, plane, TopLoc_Location(), 0.01)
        BUILDER.Range(edge, plane, TopLoc_Location(), 0.5, 0.75 + i)
    write("curves2", edge)


def surfaces() -> None:
    """Face k has the surface of kind k; then splines of every sort and a trim of an offset."""
    frame = gp_Ax3(gp_Pnt(1, 2, 3), gp_Dir(0, 0, 1), gp_Dir(0, 1, 0))
    left = gp_Ax3(gp_Pnt(1, 2, 3), gp_Dir(0, 0, 1), gp_Dir(0, 1, 0))
    left.YReverse()
    line = Geom_Line(gp_Pnt(4, 0, 0), gp_Dir(0, 0, 1))
    spline_curve = Geom_BSplineCurve(
        points([(0, 0, 0), (1, 1, 0), (2, 0, 0)]), reals([0, 1]), integers([3, 3]), 2
    )
    spline = Geom_BSplineSurface(
        pole_grid(4, 3), reals([0, 0.5, 2]), reals([-1, 1]), integers([3, 1, 3]), integers([3, 3]), 2, 2
    )
    torus = Geom_ToroidalSurface(frame, 8, 2)
    kinds = [
        Geom_Plane(frame),
        Geom_CylindricalSurface(left, 2.5),
        Geom_ConicalSurface(frame, 0.5, 3),
        Geom_SphericalSurface(frame, 4),
        torus,
        Geom_SurfaceOfLinearExtrusion(spline_curve, gp_Dir(0, 0, 1)),
        Geom_SurfaceOfRevolution(line, gp_Ax1(gp_Pnt(0, 0, 7), gp_Dir(0, 0, 1))),
        Geom_BezierSurface(pole_grid(3, 4)),
        spline,
        Geom_RectangularTrimmedSurface(torus, 0.25, 1, 0.5, 2),
        Geom_OffsetSurface(spline, 0.125),
        Geom_BezierSurface(pole_grid(2, 3), weight_grid(2, 3)),
        Geom_BSplineSurface(
            pole_grid(4, 3),
            weight_grid(4, 3),
            reals([0, 1, 2, 3, 4]),
            reals([0, 1, 2]),
            integers([1, 1, 1, 1, 1]),
            integers([2, 1, 2]),
            3,
            1,
            True,
            False,
        ),
        Geom_RectangularTrimmedSurface(Geom_OffsetSurface(torus, 1), 0.25, 1, 0.5, 2),
    ]
    faces = []
    for i, surface in enumerate(kinds):
        face = TopoDS_Face()
        BUILDER.MakeFace(face, surface, 0.001 * (i + 1))
        BUILDER.NaturalRestriction(face, i % 2 == 0)
        faces.append(face)
    write("surfaces", compound(faces))


def rotation(i: int) -> gp_Trsf:
    """A turn by 90 degrees about z for odd i, about x for even i; then a step (i, 10 i, 100 i)."""
    turn = gp_Trsf()
    axis = gp_Dir(0, 0, 1) if i % 2 else gp_Dir(1, 0, 0)
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), axis), math.pi / 2)
    step = gp_Trsf()
    step.SetTranslation(gp_Vec(i, 10 * i, 100 * i))
    return step.Multiplied(turn)


def locations() -> None:
    """A vertex at (1, 2, 3) placed by products of three placements, by powers, mirrored and scaled."""
    first, second, third = (TopLoc_Location(rotation(i)) for i in (1, 2, 3))
    mirror = gp_Trsf()
    mirror.SetMirror(gp_Ax2(gp_Pnt(0, 0, 5), gp_Dir(0, 0, 1)))
    scale = gp_Trsf()
    scale.SetScale(gp_Pnt(0, 0, 0), 3)
    vertex = TopoDS_Vertex()
    BUILDER.MakeVertex(vertex, gp_Pnt(1, 2, 3), 0.5)
    placements = [
        TopLoc_Location(),
        first,
        first.Multiplied(second),
        first.Multiplied(second).Multiplied(third),
        third.Powered(3),
        second.Powered(-2),
        first.Multiplied(second.Powered(-1)),
        TopLoc_Location(mirror),
        TopLoc_Location(scale),
    ]
    located = [vertex.Located(p, False) for p in placements]
    write("locations", compound([*located, vertex.Reversed()]))


def meshes() -> None:
    """A meshed cylinder, an edge that is a polygon only, and a face that is a mesh only."""
    cylinder = BRepPrimAPI_MakeCylinder(2.5, 7).Shape()
    BRepMesh_IncrementalMesh(cylinder, 0.5)
    polygon = Poly_Polygon3D(points([(0, 0, 0), (1, 0, 0), (1, 1, 0)]), reals([0, 1, 2]))
    edge = TopoDS_Edge()
    BUILDER.MakeEdge(edge, polygon)
    triangulation = Poly_Triangulation(4, 2, True, True)
    for i, (x, y) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)], 1):
        triangulation.SetNode(i, gp_Pnt(x, y, 0))
        triangulation.SetUVNode(i, gp_Pnt2d(x, y))
        triangulation.SetNormal(i, gp_Dir(0, 0, 1))
    triangulation.SetTriangle(1, Poly_Triangle(1, 2, 3))
    triangulation.SetTriangle(2, Poly_Triangle(1, 3, 4))
    face = TopoDS_Face()
    BUILDER.MakeFace(face, triangulation)
    everything = compound([cylinder, edge, face])
    write("meshes", everything, meshes=True)
    write("meshes_v3", everything, meshes=True, version=3)
    write("mesh_face", face)  # a face without a surface keeps its mesh in every case


def point_representations() -> None:
    """An edge with a vertex inside, known to lie on its curve; the same on a p-curve and a surface."""
    line = Geom_Line(gp_Pnt(0, 0, 0), gp_Dir(1, 0, 0))
    edge = BRepBuilderAPI_MakeEdge(line, 0, 10).Edge()
    inside = TopoDS_Vertex()
    BUILDER.MakeVertex(inside, gp_Pnt(4, 0, 0), 0.25)
    BUILDER.Add(edge, inside.Oriented(TopAbs_INTERNAL))
    BUILDER.UpdateVertex(inside, 4.0, edge, 0.25)
    plane = Geom_Plane(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
    pcurve = Geom2d_Line(gp_Ax2d(gp_Pnt2d(0, 0), gp_Dir2d(1, 0)))
    BUILDER.UpdateEdge(edge, pcurve, plane, TopLoc_Location(), 1e-7)
    BUILDER.UpdateVertex(inside, 4.0, edge, plane, TopLoc_Location(), 0.25)
    face = TopoDS_Face()
    BUILDER.MakeFace(face, plane, 1e-7)
    BUILDER.UpdateVertex(inside, 4.0, 0.0, face, 0.25)
    write("points", compound([edge, face]))


def rounded_box() -> None:
    """A box of 4 x 5 x 6 with one edge rounded; two of its 15 edges are smooth."""
    box = BRepPrimAPI_MakeBox(4, 5, 6).Shape()
    fillet = BRepFilletAPI_MakeFillet(box)
    fillet.Add(1.0, TopoDS.Edge_s(TopExp_Explorer(box, ALL.TopAbs_EDGE).Current()))
    shape = fillet.Shape()
    BRepLib.EncodeRegularity_s(shape, 1e-6)
    write("rounded_box", shape)


def main() -> None:
    DATA.mkdir(exist_ok=True)
    write("box", BRepPrimAPI_MakeBox(1, 2, 3).Solid())
    cylinder = BRepPrimAPI_MakeCylinder(2.5, 7).Shape()
    for version in (1, 2, 3, 4):
        write("cylinder" if version == 4 else f"cylinder_v{version}", cylinder, version=version)
    write("sphere", BRepPrimAPI_MakeSphere(4).Shape())
    write("torus", BRepPrimAPI_MakeTorus(8, 2).Shape())
    write("cone", BRepPrimAPI_MakeCone(3, 0, 4).Shape())
    curves3()
    curves2()
    surfaces()
    locations()
    meshes()
    point_representations()
    rounded_box()


if __name__ == "__main__":
    main()
