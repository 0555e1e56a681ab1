"""Parts of spheres that reach both poles arrive as the file says, wherever the sphere's seam lies."""

import math

import make
import pytest
import slice_of_ball
from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
from OCP.STEPControl import STEPControl_Reader

import trimray
from trimray.importer.sphere_seams import clear_seams
from trimray.importer.step_text import StepText

# (start, width, seam, flat, first edge): OpenCascade alone takes the rest of the sphere of the first three.
_CASES = [
    (90.0, 90.0, 180.0, 20.0, 2),
    (0.0, 180.0, 180.0, 20.0, 3),
    (45.0, 330.0, 0.0, None, 0),
    (0.0, 345.0, 0.0, None, 1),
    (0.0, 90.0, 0.0, None, 0),
    (200.0, 270.0, 45.0, 15.0, 1),
]


def _slice(case, *, inward=False):
    start, width, seam, flat, first = case
    return slice_of_ball.SliceOfBall(start, width, seam=seam, flat=flat, first=first, inward=inward)


def _cleared(path):
    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    return clear_seams(reader.WS().Model(), StepText(path.read_bytes()))


@pytest.mark.parametrize("heal", ["default", "off"])
@pytest.mark.parametrize("inward", [False, True])
@pytest.mark.parametrize("case", _CASES)
def test_slice_of_a_ball_is_no_more_and_no_less(case, inward, heal):
    made = _slice(case, inward=inward)
    model = trimray.load(made.text.encode(), name="slice.step", heal=heal, cache=False)
    found = model.mass_properties()
    assert [issue for issue in model.report.issues if issue.severity != "note"] == []
    assert max(found.face_areas) == pytest.approx(made.area_on_ball, rel=1e-5)
    assert abs(found.volume) == pytest.approx(made.volume, rel=1e-5)


def test_only_a_seam_on_the_loop_moves(tmp_path):
    path = tmp_path / "slice.step"
    path.write_text(_slice((90.0, 90.0, 180.0, None, 0)).text)
    (face,) = _cleared(path)
    assert f"{face}=ADVANCED_FACE" in path.read_text()
    path.write_text(_slice((90.0, 90.0, 45.0, None, 0)).text)
    assert _cleared(path) == []


def test_a_face_with_curves_on_its_sphere_keeps_its_seam(tmp_path):
    lune = BRepPrimAPI_MakeSphere(10.0, -0.5 * math.pi, 0.5 * math.pi, 0.5 * math.pi).Shape()
    path = make.step_file(tmp_path / "lune.step", lune)
    assert "PCURVE" in path.read_text()
    assert _cleared(path) == []


def test_such_a_face_of_an_external_file_is_named(read_here, tmp_path):
    (tmp_path / "inner.step").write_text(_slice(_CASES[0]).text)
    path = make.step_file(tmp_path / "outer.step", make.box())
    make.refer_to_file(path, "inner.step")
    (face,) = _cleared(tmp_path / "inner.step")
    report = read_here(path).report
    assert report["faces"] == 10
    (found,) = [issue for issue in report["issues"] if issue["severity"] == "warning"]
    assert found["entity"] == "inner.step" and found["reason"].startswith(f"{face}: ")
