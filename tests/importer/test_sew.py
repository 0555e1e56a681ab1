"""Joining edges before sewing: matching edges become one, corners cut the edges that they lie on."""

import make
import pytest
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Pln
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS

from trimray.importer.cut_edges import cut_edges
from trimray.importer.edge_map import EdgeMap, SpaceCurve
from trimray.importer.match_edges import join_matching_edges
from trimray.importer.report import Report
from trimray.importer.scene import Part
from trimray.importer.sew import sew_part
from trimray.importer.shapes import compound_of


def apart(shape):
    """Copies of the faces that share nothing."""
    return [BRepBuilderAPI_Copy(face).Shape() for face in make.faces(shape)]


def rectangle(x0, x1, y0, y1):
    return BRepBuilderAPI_MakeFace(gp_Pln(), x0, x1, y0, y1).Face()


def uses(faces):
    """Number of edges by the number of their uses."""
    counts = [len(users) for users in EdgeMap(faces).users.values()]
    return {count: counts.count(count) for count in set(counts)}


def area(shape):
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    return properties.Mass()


def worst_same_parameter(faces):
    """How far p-curves lie off the edges, parameter by parameter, in mm."""
    shapes = EdgeMap(faces)
    worst = 0.0
    for index, users in shapes.users.items():
        edge = shapes.edge(index)
        if BRep_Tool.Degenerated_s(edge):
            continue
        points = SpaceCurve(edge).even(9)
        for number in set(users):
            face = shapes.faces[number]
            curve, surface = BRepAdaptor_Curve2d(edge, face), BRepAdaptor_Surface(face)
            for k, point in enumerate(points):
                t = curve.FirstParameter() + k / 8 * (curve.LastParameter() - curve.FirstParameter())
                uv = curve.Value(t)
                on = surface.Value(uv.X(), uv.Y())
                worst = max(worst, abs(on.X() - point[0]), abs(on.Y() - point[1]), abs(on.Z() - point[2]))
    return worst


def test_faces_of_a_box_share_their_edges_again():
    faces = apart(make.box())
    assert uses(faces) == {1: 24}
    joined = join_matching_edges(faces, 1e-3)
    assert uses(joined) == {2: 12}
    assert EdgeMap(joined).vertices.Extent() == 8
    assert [area(face) for face in joined] == pytest.approx([area(face) for face in faces])
    assert worst_same_parameter(joined) < 1e-9


def test_closed_edges_match_whichever_way_they_run():
    joined = join_matching_edges(apart(make.cylinder()), 1e-3)
    assert uses(joined) == {2: 3}  # two rims, and the seam that one face uses twice
    assert worst_same_parameter(joined) < 1e-9


def test_corner_cuts_the_edge_that_it_lies_on():
    faces = [rectangle(0, 20, 0, 10), rectangle(0, 8, 10, 20), rectangle(8, 20, 10, 20)]
    assert uses(join_matching_edges(faces, 1e-3)) == {1: 10, 2: 1}  # only the edge between the two small ones
    joined = join_matching_edges(cut_edges(faces, 1e-3), 1e-3)
    assert uses(joined) == {1: 7, 2: 3}
    assert [area(face) for face in joined] == pytest.approx([200, 80, 120])
    assert worst_same_parameter(joined) < 1e-9


def test_faces_without_free_edges_stay_the_same():
    faces = make.faces(make.box())
    assert cut_edges(faces, 1e-3) is faces
    assert join_matching_edges(faces, 1e-3) is faces


def test_edges_farther_apart_than_tolerance_stay_apart():
    faces = [rectangle(0, 10, 0, 10), rectangle(0, 10, 10.01, 20)]
    assert join_matching_edges(faces, 5e-3) == faces
    assert uses(join_matching_edges(faces, 2e-2)) == {1: 6, 2: 1}


def test_edge_that_matches_two_others_is_left_to_sewing():
    faces = [rectangle(0, 10, 0, 10), rectangle(0, 10, 10, 20), rectangle(0, 10, 10, 30)]
    assert join_matching_edges(faces, 1e-3) == faces


def test_both_ways_of_sewing_agree(monkeypatch):
    faces = apart(make.box())
    shells = []
    for limit in (1000, 1):
        monkeypatch.setattr("trimray.importer.sew._MANY_FREE_EDGES", limit)
        part = Part(compound_of(faces), "box", face_colors=[(faces[2], (1.0, 0.0, 0.0, 1.0))])
        report = Report()
        sew_part(part, 1e-3, report)
        assert report.issues == []
        assert uses(make.faces(part.shape)) == {2: 12}
        ((colored, _),) = part.face_colors
        assert area(TopoDS.Face_s(colored)) == pytest.approx(area(faces[2]))
        assert any(face.IsSame(colored) for face in make.faces(part.shape))
        volume = GProp_GProps()
        BRepGProp.VolumeProperties_s(part.shape, volume)
        shells.append(volume.Mass())
    assert shells == pytest.approx([6000.0, 6000.0])
