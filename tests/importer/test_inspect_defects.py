"""Defects that were put into shapes, and how an inspection names them."""

import math

import make
import numpy as np
import pytest
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_Sewing
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.Geom import Geom_BezierSurface
from OCP.GeomAbs import GeomAbs_Shape
from OCP.gp import gp_Pnt, gp_Vec, gp_Vec2d
from OCP.TColgp import TColgp_Array2OfPnt
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape, TopoDS_Shell, TopoDS_Solid

import trimray
from trimray.importer.inspection import Fault, Inspection
from trimray.importer.shapes import compound_of


def _shell(faces: list[TopoDS_Shape], *, solid: bool = False) -> TopoDS_Shape:
    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    if not solid:
        return shell
    body = TopoDS_Solid()
    builder.MakeSolid(body)
    builder.Add(body, shell)
    return body


def _edges(shape: TopoDS_Shape) -> list[TopoDS_Shape]:
    found = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def _of_kind(found: Inspection, kind: str) -> list[Fault]:
    return [fault for fault in found.faults if fault.kind == kind]


def test_a_missing_face_leaves_free_edges() -> None:
    found = trimray.inspect(_shell(make.faces(make.box())[1:]))
    assert (found.topology.shells, found.topology.closed_shells, found.topology.free_edges) == (1, 0, 4)
    assert len(_of_kind(found, "free edge")) == 4
    assert found.mass.volume == 0.0
    assert found.mass.centroid is None
    assert found.mass.area == pytest.approx(2200.0 - 600.0)
    assert np.isnan(found.edges.gap).sum() == 4


def test_a_flipped_face_is_no_neighbour_to_its_neighbours() -> None:
    faces = make.faces(make.box())
    found = trimray.inspect(_shell([faces[0].Reversed(), *faces[1:]], solid=True))
    faults = _of_kind(found, "non-manifold edge")
    assert len(faults) == found.topology.nonmanifold_edges == 4
    assert all(0 in fault.faces for fault in faults)
    assert "in one direction" in faults[0].what
    assert found.topology.closed_shells == 0
    assert any("orient" in fault.what for fault in _of_kind(found, "invalid"))


def test_a_shell_that_looks_inwards_is_named() -> None:
    found = trimray.inspect(_shell([face.Reversed() for face in make.faces(make.box())], solid=True))
    assert found.mass.volume == pytest.approx(-6000.0)
    assert found.topology.inside_out_shells == 1
    assert [fault.faces for fault in _of_kind(found, "inside out")] == [(0, 1, 2, 3, 4, 5)]


def test_a_hollow_is_not_inside_out() -> None:
    outer = TopoDS_Solid()
    builder = BRep_Builder()
    builder.MakeSolid(outer)
    builder.Add(outer, _shell(make.faces(make.box(30, 30, 30))))
    inner = _shell([face.Reversed() for face in make.faces(make.box(10, 10, 10))])
    builder.Add(outer, inner.Moved(make.moved(5, 5, 5)))
    found = trimray.inspect(outer)
    assert found.mass.volume == pytest.approx(27000.0 - 1000.0)
    assert found.topology.inside_out_shells == 0
    assert found.topology.closed_shells == 2
    assert found.faults == ()


@pytest.mark.parametrize("off", [1e-3, 1e-5])
def test_a_pulled_p_curve_is_measured(off: float) -> None:
    shape = make.cylinder()
    side = TopoDS.Face_s(make.faces(shape)[0])
    circle = next(TopoDS.Edge_s(e) for e in _edges(side) if not BRep_Tool.IsClosed_s(TopoDS.Edge_s(e), side))
    curve = BRep_Tool.CurveOnSurface_s(circle, side, 0.0, 0.0)
    BRep_Builder().UpdateEdge(circle, curve.Translated(gp_Vec2d(0.0, off)), side, 1e-7)
    found = trimray.inspect(shape)
    faults = _of_kind(found, "edge off its face")
    assert [fault.value for fault in faults] == pytest.approx([off], rel=1e-6)
    assert faults[0].allowed == pytest.approx(1e-7)
    assert 0 in faults[0].faces
    assert found.edges.worst("gap", 1)[0]["gap"] == pytest.approx(off, rel=1e-6)
    # A strip of height ``off`` around the cylinder: its area, and its volume by the divergence theorem.
    assert found.mass.area_noise == pytest.approx(2 * math.pi * 5.0 * off, rel=1e-3)
    assert found.mass.volume_noise == pytest.approx(2 * math.pi * 5.0 * off * 5.0 / 3.0, rel=1e-3)


def test_a_p_curve_at_other_parameters_is_out_of_step() -> None:
    shape = make.cylinder()
    side = TopoDS.Face_s(make.faces(shape)[0])
    circle = next(TopoDS.Edge_s(e) for e in _edges(side) if not BRep_Tool.IsClosed_s(TopoDS.Edge_s(e), side))
    curve = BRep_Tool.CurveOnSurface_s(circle, side, 0.0, 0.0)
    BRep_Builder().UpdateEdge(circle, curve.Translated(gp_Vec2d(1e-3, 0.0)), side, 1e-7)
    found = trimray.inspect(shape)
    assert _of_kind(found, "edge off its face") == []
    (fault,) = _of_kind(found, "edge out of step")
    assert fault.faces == (0,)
    assert fault.value == pytest.approx(2 * 5.0 * math.sin(0.5e-3), rel=1e-6)
    assert found.mass.area_noise < 1e-9


def test_a_vertex_off_its_edges_is_measured() -> None:
    shape = make.box()
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_VERTEX)
    vertex = TopoDS.Vertex_s(explorer.Current())
    place = BRep_Tool.Pnt_s(vertex)
    BRep_Builder().UpdateVertex(vertex, place.Translated(gp_Vec(0.0, 0.0, 1e-2)), 1e-7)
    found = trimray.inspect(shape)
    faults = _of_kind(found, "vertex off its edge")
    assert len(faults) == 3
    assert [fault.value for fault in faults] == pytest.approx([1e-2] * 3)
    assert any("vertex" in fault.what for fault in _of_kind(found, "invalid"))


def test_three_faces_at_one_edge_are_not_manifold() -> None:
    sewing = BRepBuilderAPI_Sewing(1e-6)
    sewing.SetNonManifoldMode(True)
    for turn in (0.0, 2.0, 4.0):
        sewing.Add(BRepBuilderAPI_MakeFace(_rectangle(turn)).Face())
    sewing.Perform()
    found = trimray.inspect(_shell(make.faces(sewing.SewedShape())))
    (fault,) = _of_kind(found, "non-manifold edge")
    assert fault.faces == (0, 1, 2)
    assert found.edges.uses.max() == 3
    assert found.topology.nonmanifold_edges == 1
    assert found.topology.free_edges == 9


def _rectangle(turn: float) -> TopoDS_Shape:
    x, y = 10.0 * math.cos(turn), 10.0 * math.sin(turn)
    corners = [gp_Pnt(0, 0, 0), gp_Pnt(x, y, 0), gp_Pnt(x, y, 5), gp_Pnt(0, 0, 5)]
    return BRepBuilderAPI_MakePolygon(*corners, True).Wire()


def test_a_fillet_is_smooth_where_it_ends() -> None:
    shape = make.box()
    fillet = BRepFilletAPI_MakeFillet(shape)
    fillet.Add(2.0, TopoDS.Edge_s(_edges(shape)[0]))
    found = trimray.inspect(fillet.Shape())
    flat = found.edges.angle < 1e-9
    assert flat.sum() == 2
    assert found.edges.angle[~flat].min() == pytest.approx(math.pi / 2)
    assert found.topology.faces_by_kind == {"cylinder": 1, "plane": 6}
    # Rounding an edge of length 30 with radius 2 takes away (4 - pi) r^2 / 4 of its section.
    assert found.mass.volume == pytest.approx(6000.0 - (1 - math.pi / 4) * 4.0 * 30.0, rel=1e-13)


def test_a_sharp_edge_that_claims_to_be_smooth_is_told_by_its_angle() -> None:
    shape = make.box()
    first, second = (TopoDS.Face_s(face) for face in (make.faces(shape)[0], make.faces(shape)[2]))
    shared = next(e for e in _edges(first) if any(e.IsSame(other) for other in _edges(second)))
    BRep_Builder().Continuity(TopoDS.Edge_s(shared), first, second, GeomAbs_Shape.GeomAbs_G1)
    edges = trimray.inspect(shape).edges
    assert edges.smooth.sum() == 1
    assert edges.angle[edges.smooth] == pytest.approx([math.pi / 2])
    assert edges.faces[edges.smooth].tolist() == [[0, 2]]


def test_a_face_of_two_solids_is_no_fold() -> None:
    """The side of a cylinder, once for each of two shells: its seam is smooth, and so it claims to be."""
    side = make.faces(make.cylinder())[0]
    assert BRep_Tool.Surface_s(TopoDS.Face_s(side)).IsUPeriodic()
    both = compound_of([_shell([face]) for face in (side, side.Reversed())])
    edges = trimray.inspect(both).edges
    assert (edges.uses[edges.smooth] == 4).all() and edges.smooth.any()
    assert edges.angle[edges.smooth] == pytest.approx(0.0, abs=1e-9)


def test_a_normal_that_is_noise_at_a_pole_makes_no_angle() -> None:
    """A patch with a side of 1e-9 mm that runs backwards, beside a rectangle in the same plane."""
    points = TColgp_Array2OfPnt(1, 2, 1, 2)
    for i, j, x, y in ((1, 1, 0, 0), (1, 2, 0, -1e-9), (2, 1, 10, 0), (2, 2, 10, 10)):
        points.SetValue(i, j, gp_Pnt(x, y, 0))
    patch = BRepBuilderAPI_MakeFace(Geom_BezierSurface(points), 1e-7).Face()
    corners = [gp_Pnt(0, 0, 0), gp_Pnt(0, -5, 0), gp_Pnt(10, -5, 0), gp_Pnt(10, 0, 0)]
    flat = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakePolygon(*corners, True).Wire()).Face()
    sewing = BRepBuilderAPI_Sewing(1e-6)
    sewing.Add(patch)
    sewing.Add(flat)
    sewing.Perform()
    edges = trimray.inspect(sewing.SewedShape()).edges
    shared = edges.uses == 2
    assert shared.sum() == 1
    assert edges.angle[shared] == pytest.approx(0.0, abs=1e-6)


def test_face_numbers_are_those_of_the_model() -> None:
    face = make.faces(make.cylinder(3.0, 1.0))[0]
    both = compound_of([make.cylinder().Moved(make.moved(50.0)), make.box(), face])
    found, model = trimray.inspect(both), trimray.load(both)
    assert len(found.face_areas) == len(model.faces) == 10
    assert [face.kind for face in model.faces] == ["cylinder", *["plane"] * 8, "cylinder"]
    expected = [120 * math.pi, 25 * math.pi, 25 * math.pi, 600, 600, 300, 300, 200, 200, 6 * math.pi]
    assert sorted(found.face_areas[3:9]) == pytest.approx(sorted(expected[3:9]))
    assert found.face_areas[[0, 1, 2, 9]] == pytest.approx([expected[i] for i in (0, 1, 2, 9)])
    assert found.topology.lone_faces == 1
    assert {number for fault in _of_kind(found, "free edge") for number in fault.faces} == {9}


def test_a_face_that_cannot_be_drawn_is_left_out() -> None:
    """And the volume of its shell; other shells have theirs."""
    broken = make.cylinder()
    side = TopoDS.Face_s(make.faces(broken)[0])
    circle = next(TopoDS.Edge_s(e) for e in _edges(side) if not BRep_Tool.IsClosed_s(TopoDS.Edge_s(e), side))
    far = BRep_Tool.CurveOnSurface_s(circle, side, 0.0, 0.0).Translated(gp_Vec2d(0.0, 1e6))
    BRep_Builder().UpdateEdge(circle, far, side, 1e-7)
    found = trimray.inspect(compound_of([make.box(), broken]))
    assert found.mass.left_out == (6,)
    assert np.flatnonzero(np.isnan(found.face_areas)).tolist() == [6]
    assert found.mass.volume == pytest.approx(6000.0, rel=1e-13)
    assert found.mass.area == pytest.approx(2200.0 + 50 * math.pi, rel=1e-13)
    assert found.topology.inside_out_shells == 0


def test_an_edge_without_a_curve_in_space_is_named() -> None:
    shape = make.cylinder()
    edge = TopoDS.Edge_s(_edges(shape)[0])
    BRep_Builder().UpdateEdge(edge, None, TopLoc_Location(), 1e-7)
    found = trimray.inspect(shape)
    assert found.topology.faces == 3
    assert any("curve in space" in fault.what for fault in found.faults)
