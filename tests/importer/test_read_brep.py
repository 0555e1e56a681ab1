"""OpenCascade's own files."""

import make
import parse_brep
import pytest
from OCP.BinTools import BinTools
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.gp import gp_Pnt

from trimray.importer import EmptyError, InputError


def test_text_brep_is_read_and_keeps_its_location(read_here, tmp_path):
    model = read_here(make.brep_file(tmp_path / "a.brep", make.box().Moved(make.moved(5, 6, 7))))
    assert model.report["faces"] == 6 and model.unit == "mm"
    assert model.instance_placements[0][[3, 7, 11]] == pytest.approx([5, 6, 7])
    assert parse_brep.bounds(parse_brep.prototype(model, 0)) == pytest.approx((0, 0, 0, 10, 20, 30), abs=1e-6)


def test_binary_brep_is_read(read_here, tmp_path):
    assert BinTools.Write_s(make.cylinder(), str(tmp_path / "a.brep"))
    assert read_here(tmp_path / "a.brep").report["faces"] == 3


@pytest.mark.parametrize("write", [make.brep_file, make.step_file, make.iges_file])
def test_a_file_of_curves_says_so(read_here, tmp_path, write):
    path = write(tmp_path / "sketch", BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 2, 3)).Edge())
    with pytest.raises(EmptyError, match="no faces: 1 shape is curves or points: not drawn"):
        read_here(path)


def test_truncated_brep_is_an_error(read_here, tmp_path):
    path = make.brep_file(tmp_path / "a.brep", make.box())
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(InputError):
        read_here(path)
