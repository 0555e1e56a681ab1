"""What is said about faces that cannot be drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trimray
from trimray.faces import Face
from trimray.report import Issue, Report


def faces_file(path: Path, *, triangles: bool) -> Path:
    """Two faces without a surface: with a triangle each, as tessellated files have them, or with nothing."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.gp import gp_Pnt
    from OCP.Poly import Poly_Triangle, Poly_Triangulation
    from OCP.TopoDS import TopoDS_Compound, TopoDS_Face

    builder, all_faces = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(all_faces)
    for z in (0.0, 5.0):
        face = TopoDS_Face()
        builder.MakeFace(face)
        if triangles:
            mesh = Poly_Triangulation(3, 1, False)
            for i, (x, y) in enumerate(((0, 0), (1, 0), (0, 1)), 1):
                mesh.SetNode(i, gp_Pnt(x, y, z))
            mesh.SetTriangle(1, Poly_Triangle(1, 2, 3))
            builder.MakeFace(face, mesh)
        builder.Add(all_faces, face)
    assert BRepTools.Write_s(all_faces, str(path))
    return path


def test_faces_of_triangles_are_drawn(tmp_path: Path) -> None:
    model = trimray.load(faces_file(tmp_path / "triangles.brep", triangles=True))
    assert [face.kind for face in model.faces] == ["mesh", "mesh"] and model.report.drawn == 2
    np.testing.assert_array_equal(model.bounds, [[0, 0, 0], [1, 1, 5]])
    hits = model.cast([[0.25, 0.25, 9.0], [0.75, 0.75, 9.0]], [[0, 0, -1], [0, 0, -1]])
    np.testing.assert_array_equal(hits.face, [1, -1])
    np.testing.assert_allclose(hits.t, [4.0, np.inf])
    np.testing.assert_allclose(hits.uv[0], [0.25, 0.25])
    np.testing.assert_allclose(hits.normal[0], [0, 0, 1])


def test_a_model_without_a_drawable_face_says_why(tmp_path: Path) -> None:
    path = faces_file(tmp_path / "nothing.brep", triangles=False)
    model = trimray.load(path)
    assert len(model.faces) == 2 and model.report.drawn == 0
    for ask in (lambda: model.bounds, lambda: model.render((8, 8))):
        with pytest.raises(trimray.EmptyError) as caught:
            ask()
        text = str(caught.value)
        assert text.startswith(f"{path}: no face can be drawn: faces 0-1 (none")
        assert "neither a surface nor triangles" in text and "\n" not in text


def lost(number: int, kind: str = "plane", status: str = "broken", part: str = "") -> Face:
    return Face(number, kind, None, "", part, status)


def test_reasons_are_one_line_for_faces_of_one_fate() -> None:
    report = Report(
        None, 20, 14, (lost(3), lost(7), lost(8), lost(9), lost(12, "torus"), lost(13, part="Lid"))
    )
    assert report.reasons() == [
        "faces 3, 7-9 (plane): broken",
        "face 12 (torus): broken",
        "face 13 (plane of Lid): broken",
    ]
    assert len(report.problems()) == 6


def test_reasons_of_many_are_short() -> None:
    issues = tuple(Issue(f"#{n}", "ADVANCED_FACE", "no bounds", "error") for n in range(100))
    report = Report(
        None, 200, 100, tuple(lost(2 * n) for n in range(100)), (*issues, Issue("#5", "X", "y", "note"))
    )
    faces, entities = report.reasons()
    assert faces.startswith("faces 0, 2, 4") and "22 and 88 more (plane)" in faces
    assert entities.endswith("#11 and 88 more (ADVANCED_FACE): no bounds")
