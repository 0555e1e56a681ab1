"""IGES: trimmed surfaces, solids, sewing, repair of sloppy files, and what is not understood."""

import make
import parse_brep
import pytest
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from trimray.importer import EmptyError, InputError, iges_text


def edge_users(shape):
    """How many faces each edge of the shape has."""
    users = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE, users)
    return [users.FindFromIndex(i).Extent() for i in range(1, users.Extent() + 1)]


def test_trimmed_surfaces_are_sewn_into_a_closed_solid(read_here, tmp_path):
    model = read_here(make.iges_file(tmp_path / "box.igs", make.box()))
    shape = parse_brep.prototype(model, 0)
    assert model.report["faces_in_file"] == model.report["faces"] == 6
    assert len(model.prototype_shapes) == 1
    assert edge_users(shape) == [2] * 12
    volume = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, volume)
    assert volume.Mass() == pytest.approx(10 * 20 * 30, rel=1e-6)  # positive: normals point outward
    assert "sew" in model.report["seconds"]


def test_solid_186_keeps_its_topology(read_here, tmp_path):
    model = read_here(make.iges_file(tmp_path / "cylinder.igs", make.cylinder(), solids=True))
    assert model.report["faces"] == model.report["faces_in_file"] == 3
    assert len(model.prototype_shapes) == 1


def test_unit_is_named_and_geometry_stays_mm(read_here, tmp_path):
    model = read_here(make.iges_file(tmp_path / "box.igs", make.box(), unit="IN"))
    assert (model.unit, model.unit_mm) == ("inch", 25.4)
    assert parse_brep.bounds(parse_brep.prototype(model, 0)) == pytest.approx((0, 0, 0, 10, 20, 30), abs=1e-5)


def test_colors_survive_sewing(read_here, real_model):
    model = read_here(real_model("BRL-CAD+brlcad/wing128.igs"))
    assert len(model.face_colors) == 2
    shapes = parse_brep.shapes_of(model)
    for index in model.face_color_shapes:
        assert shapes.Shape(int(index)).ShapeType() == TopAbs_ShapeEnum.TopAbs_FACE


def test_sloppy_teapot_is_repaired_and_says_so(read_here, real_model):
    model = read_here(real_model("vrsys+gpucast/teapot.igs"))
    assert model.report["faces"] == model.report["faces_in_file"] == 32
    repairs = [i["reason"] for i in model.report["issues"] if i["reason"].startswith("repaired: ")]
    assert any("directory and parameter" in reason for reason in repairs)
    clean = read_here(real_model("derived/utah_teapot_32patches.step"))
    boxes = [parse_brep.bounds(parse_brep.prototype(clean, i)) for i in range(32)]
    low = [min(box[axis] for box in boxes) for axis in range(3)]
    high = [max(box[axis] for box in boxes) for axis in range(3, 6)]
    assert parse_brep.bounds(parse_brep.prototype(model, 0)) == pytest.approx((*low, *high), abs=1e-6)


def test_constructive_solids_are_named_one_by_one(read_here, real_model):
    with pytest.raises(EmptyError) as caught:
        read_here(real_model("BRL-CAD+brlcad/ge6.igs"))
    issues = [i for i in caught.value.report["issues"] if i["severity"] == "error"]
    assert issues and all(i["entity"].startswith("D") and "not read" in i["reason"] for i in issues)


def test_good_file_is_not_rewritten(tmp_path):
    text = iges_text.parse(make.iges_file(tmp_path / "box.igs", make.box()).read_bytes())
    assert text.problems == [] and text.truncated is None


def test_rewriting_keeps_every_entity(tmp_path):
    text = iges_text.parse(make.iges_file(tmp_path / "box.igs", make.box()).read_bytes())
    again = iges_text.parse(iges_text.rewrite(text))
    assert again.problems == []
    assert again.entities == text.entities


@pytest.mark.parametrize("keep", [0.3, 0.7])
def test_truncated_file_is_an_error(read_here, tmp_path, keep):
    path = make.iges_file(tmp_path / "box.igs", make.box())
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep)])
    with pytest.raises(InputError, match="truncated"):
        read_here(path)


def test_parsing_never_fails_on_noise():
    import random

    noise = random.Random(7)
    for size in (0, 1, 80, 4000):
        iges_text.parse(noise.randbytes(size)).entities  # noqa: B018
