"""Inspections of shapes whose counts and mass properties are known in closed form."""

import json
import math

import make
import numpy as np
import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.Poly import Poly_Triangle, Poly_Triangulation
from OCP.TopoDS import TopoDS_Face, TopoDS_Shell

import trimray
from trimray.importer import UsageError


def _hole() -> object:
    """A box of 10 x 20 x 30 with a hole of radius 2 through its middle, along z."""
    axis = gp_Ax2(gp_Pnt(5, 10, -1), gp_Dir(0, 0, 1))
    return BRepAlgoAPI_Cut(make.box(), BRepPrimAPI_MakeCylinder(axis, 2.0, 32.0).Shape()).Shape()


def _disc(mass: float, radius: float, height: float) -> tuple[float, float, float]:
    side = mass * (3 * radius**2 + height**2) / 12
    return side, side, mass * radius**2 / 2


# name -> shape, volume, area, centroid, inertia's diagonal, faces by kind
_R, _H = 5.0, 12.0
_CYLINDER = math.pi * _R**2 * _H
_SPHERE = 4 / 3 * math.pi * 7.0**3
_TORUS = 2 * math.pi**2 * 10.0 * 9.0
_ROUND = math.pi * 4.0 * 30.0
_BOX_INERTIA = np.array([6000 * (400 + 900) / 12, 6000 * (100 + 900) / 12, 6000 * (100 + 400) / 12])
_CASES = {
    "box": (make.box, 6000.0, 2200.0, (5, 10, 15), _BOX_INERTIA, {"plane": 6}),
    "cylinder": (
        make.cylinder,
        _CYLINDER,
        2 * math.pi * _R * (_R + _H),
        (0, 0, 6),
        np.array(_disc(_CYLINDER, _R, _H)),
        {"cylinder": 1, "plane": 2},
    ),
    "sphere": (
        lambda: BRepPrimAPI_MakeSphere(7.0).Shape(),
        _SPHERE,
        4 * math.pi * 49.0,
        (0, 0, 0),
        np.full(3, 0.4 * _SPHERE * 49.0),
        {"sphere": 1},
    ),
    "torus": (
        lambda: BRepPrimAPI_MakeTorus(10.0, 3.0).Shape(),
        _TORUS,
        4 * math.pi**2 * 30.0,
        (0, 0, 0),
        _TORUS * np.array([(4 * 100 + 5 * 9) / 8] * 2 + [(4 * 100 + 3 * 9) / 4]),
        {"torus": 1},
    ),
    "hole": (
        _hole,
        6000.0 - _ROUND,
        2200.0 - 2 * math.pi * 4 + 2 * math.pi * 2 * 30,
        (5, 10, 15),
        _BOX_INERTIA - np.array(_disc(_ROUND, 2.0, 30.0)),
        {"cylinder": 1, "plane": 6},
    ),
}


@pytest.mark.parametrize("name", _CASES)
def test_mass_properties_have_their_closed_forms(name: str) -> None:
    shape, volume, area, centroid, inertia, kinds = _CASES[name]
    found = trimray.inspect(shape(), name=name)
    mass = found.mass
    assert abs(mass.volume - volume) <= mass.volume_error < 1e-12 * volume
    assert abs(mass.area - area) <= mass.area_error < 1e-12 * area
    assert mass.volume_noise < 1e-9 * volume
    assert np.allclose(mass.centroid, centroid, rtol=0, atol=1e-11)
    assert np.allclose(np.reshape(mass.inertia, (3, 3)), np.diag(inertia), rtol=0, atol=1e-12 * inertia.max())
    assert found.topology.faces_by_kind == kinds
    assert found.topology.closed_shells == found.topology.shells == found.topology.solids == 1
    assert found.face_areas.sum() == pytest.approx(area, rel=1e-12)
    assert found.faults == ()


def test_a_cylinder_has_a_seam_and_a_sphere_has_poles() -> None:
    cylinder = trimray.inspect(make.cylinder()).topology
    assert (cylinder.edges, cylinder.vertices, cylinder.seam_edges, cylinder.loops) == (3, 2, 1, 3)
    assert cylinder.edges_by_kind == {"circle": 2, "line": 1}
    sphere = trimray.inspect(BRepPrimAPI_MakeSphere(1.0).Shape()).topology
    assert (sphere.seam_edges, sphere.degenerate_edges) == (1, 2)
    assert sphere.edges_by_kind == {"circle": 1}


def test_the_edges_of_a_box_are_sharp_and_tight() -> None:
    edges = trimray.inspect(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()).edges
    assert len(edges.edge) == 12
    assert np.allclose(edges.angle, math.pi / 2, rtol=1e-15)
    assert edges.gap.max() < 1e-15
    assert edges.deviation.max() < 1e-15
    assert sorted(edges.length.tolist()) == pytest.approx([1.0] * 4 + [2.0] * 4 + [3.0] * 4)
    assert not edges.smooth.any()
    assert [row["angle"] for row in edges.worst("angle", 3)] == pytest.approx([math.pi / 2] * 3)


def test_instances_count_in_the_whole(tmp_path) -> None:
    document = make.Document()
    part = document.part(make.box(), "box")
    assembly = document.assembly("two")
    document.component(assembly, part, make.moved(100.0), "left")
    document.component(assembly, part, make.moved(200.0, turn_z=math.pi / 2), "right")
    path = document.write(tmp_path / "two.step")
    found = trimray.inspect(path)
    assert found.mass.volume == pytest.approx(12000.0, rel=1e-12)
    # Middles (105, 10, 15) and (190, 5, 15).
    assert np.allclose(found.mass.centroid, (147.5, 7.5, 15.0), atol=1e-9)
    turned = _BOX_INERTIA[[1, 0, 2]]
    arm = np.array([42.5, -2.5, 0.0])  # from the middle of both to one of them
    steiner = 12000.0 * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    expected = np.diag(_BOX_INERTIA + turned) + steiner
    assert np.allclose(np.reshape(found.mass.inertia, (3, 3)), expected, rtol=1e-12, atol=1e-6)
    assert found.topology.faces == 12
    assert [(p.name, p.instances, p.faces, p.topology.faces) for p in found.prototypes] == [
        ("box", 2, (0, 6), 6)
    ]
    counts = {c.name: (c.declared, c.arrived) for c in found.counts}
    assert counts["faces"] == (6, 6)
    assert counts["solids"] == (1, 1)
    assert counts["edges"] == (12, 12)
    assert counts["vertices"] == (8, 8)
    assert counts["products"] == (2, 2)
    assert counts["instances"] == (2, 2)
    assert found.entities["ADVANCED_FACE"] == 6
    assert json.loads(json.dumps(found.as_dict()))["mass"]["volume"] == found.mass.volume


def test_a_shell_of_triangles_has_a_volume() -> None:
    """A tetrahedron as one face without a surface, as tessellated files have them."""
    mesh = Poly_Triangulation(4, 4, False)
    for i, corner in enumerate([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], 1):
        mesh.SetNode(i, gp_Pnt(*corner))
    for i, side in enumerate([(1, 3, 2), (1, 2, 4), (2, 3, 4), (3, 1, 4)], 1):
        mesh.SetTriangle(i, Poly_Triangle(*side))
    builder, face, shell = BRep_Builder(), TopoDS_Face(), TopoDS_Shell()
    builder.MakeFace(face, mesh)
    builder.MakeShell(shell)
    builder.Add(shell, face)
    mass = trimray.inspect(shell).mass
    assert mass.volume == pytest.approx(1 / 6, rel=1e-14)
    assert mass.area == pytest.approx(1.5 + math.sqrt(0.75), rel=1e-14)
    assert mass.centroid == pytest.approx((0.25, 0.25, 0.25), rel=1e-14)


def test_triangles_have_nothing_to_inspect(tmp_path) -> None:
    path = tmp_path / "t.off"
    path.write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    with pytest.raises(UsageError, match="no B-rep to inspect"):
        trimray.inspect(path)
