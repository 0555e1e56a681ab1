"""STEP: colours, names, instances, units, references, and what the report says."""

import math
import re
from pathlib import Path

import make
import numpy as np
import parse_brep
import pytest
from OCP.TopAbs import TopAbs_ShapeEnum

import trimray
from trimray.importer import EmptyError, InputError
from trimray.importer.step_text import StepText


def test_box_arrives_with_six_faces_in_mm(read_here, tmp_path):
    model = read_here(make.step_file(tmp_path / "box.step", make.box()))
    assert model.report["faces_in_file"] == model.report["faces"] == 6
    assert model.report["issues"] == []
    assert (model.unit, model.unit_mm) == ("mm", 1.0)
    assert parse_brep.bounds(parse_brep.prototype(model, 0)) == pytest.approx((0, 0, 0, 10, 20, 30), abs=1e-6)
    assert {"parse", "transfer", "extract"} <= model.report["seconds"].keys()


@pytest.mark.parametrize(
    ("unit", "name", "size"), [("INCH", "inch", 25.4), ("M", "m", 1000.0), ("CM", "cm", 10.0)]
)
def test_unit_is_named_and_geometry_stays_mm(read_here, tmp_path, unit, name, size):
    model = read_here(make.step_file(tmp_path / "box.step", make.box(), unit=unit))
    assert (model.unit, model.unit_mm) == (name, size)
    assert parse_brep.bounds(parse_brep.prototype(model, 0)) == pytest.approx((0, 0, 0, 10, 20, 30), abs=1e-6)


def test_shape_indices_are_positions_in_the_stream(read_here, tmp_path):
    document = make.Document()
    shape = make.box()
    part = document.part(shape, "box")
    colored = make.faces(shape)[4]
    document.color(document.subshape(part, colored), make.rgba(1, 0, 0))
    model = read_here(document.write(tmp_path / "box.step"))
    shapes = parse_brep.shapes_of(model)
    assert shapes.Shape(int(model.prototype_shapes[0])).ShapeType() == TopAbs_ShapeEnum.TopAbs_SOLID
    (index,) = model.face_color_shapes
    face = shapes.Shape(int(index))
    assert face.ShapeType() == TopAbs_ShapeEnum.TopAbs_FACE
    assert parse_brep.bounds(face) == pytest.approx(parse_brep.bounds(colored), abs=1e-6)


def test_colors_come_back_as_the_file_says_them(read_here, tmp_path):
    document = make.Document()
    shape = make.box()
    part = document.part(shape, "box")
    document.color(part, make.rgba(0.5, 0.25, 0.75))
    document.color(document.subshape(part, make.faces(shape)[0]), make.rgba(0.1, 0.2, 0.9))
    path = document.write(tmp_path / "box.step")
    assert "0.5" in path.read_text() and "COLOUR_RGB" in path.read_text()
    model = read_here(path)
    assert model.prototype_colors[0] == pytest.approx([0.5, 0.25, 0.75, 1.0], abs=2e-6)
    assert len(model.face_colors) == 1
    assert model.face_colors[0] == pytest.approx([0.1, 0.2, 0.9, 1.0], abs=2e-6)


def test_transparency_is_kept(read_here, tmp_path):
    document = make.Document()
    document.color(document.part(make.box(), "glass"), make.rgba(0.2, 0.4, 0.6, 0.25))
    model = read_here(document.write(tmp_path / "glass.step"))
    assert model.prototype_colors[0] == pytest.approx([0.2, 0.4, 0.6, 0.25], abs=1e-5)


def test_curve_color_colors_no_surface(read_here, tmp_path):
    document = make.Document()
    document.color(document.part(make.box(), "box"), make.rgba(0.2, 0.4, 0.6), make.CURVE_COLOR)
    model = read_here(document.write(tmp_path / "box.step"))
    assert model.prototype_colors[0, 0] < 0
    assert len(model.face_colors) == 0


def test_nested_assembly_multiplies_placements_and_stores_a_part_once(read_here, tmp_path):
    document = make.Document()
    bolt = document.part(make.cylinder(), "bolt")
    pair = document.assembly("pair")
    document.component(pair, bolt, make.moved(100), "left")
    document.component(pair, bolt, make.moved(0, 50), "right")
    top = document.assembly("top")
    document.component(top, pair, make.moved(0, 0, 7), "pair_1")
    document.component(top, pair, make.moved(0, 0, 9, turn_z=math.pi / 2), "pair_2")
    model = read_here(document.write(tmp_path / "top.step"))
    assert model.prototype_names == ("bolt",)
    assert len(model.instance_prototypes) == 4
    assert model.report["faces"] == 3 and model.report["face_uses"] == 12
    paths = {
        instance.path[1:]: model.instance_placements[i].reshape(3, 4)
        for i, instance in enumerate(model.instances)
    }
    assert paths["pair_1", "left"] == pytest.approx(
        np.array([[1, 0, 0, 100], [0, 1, 0, 0], [0, 0, 1, 7]]), abs=1e-9
    )
    # Turned by 90 degrees, +x becomes +y.
    turned = np.array([[0, -1, 0, 0], [1, 0, 0, 100], [0, 0, 1, 9]])
    assert paths["pair_2", "left"] == pytest.approx(turned, abs=1e-9)
    assert paths["pair_2", "right"][:, 3] == pytest.approx([-50, 0, 9], abs=1e-9)
    for instance in model.instances:  # the tree says the same as the placements
        matrix, node = np.eye(4), instance.node
        while node >= 0:
            local = np.vstack([np.reshape(model.tree[node].placement, (3, 4)), [0, 0, 0, 1]])
            matrix, node = local @ matrix, model.tree[node].parent
        index = model.instances.index(instance)
        assert matrix[:3] == pytest.approx(model.instance_placements[index].reshape(3, 4), abs=1e-9)


def test_component_color_goes_to_its_instance_only(read_here, tmp_path):
    document = make.Document()
    part = document.part(make.box(), "box")
    document.color(part, make.rgba(0.2, 0.2, 0.2))
    top = document.assembly("top")
    document.color(document.component(top, part, make.moved(1), "red"), make.rgba(1, 0, 0))
    document.component(top, part, make.moved(2), "plain")
    model = read_here(document.write(tmp_path / "top.step"))
    colors = {instance.name: model.instance_colors[i] for i, instance in enumerate(model.instances)}
    assert colors["red"] == pytest.approx([1, 0, 0, 1], abs=2e-6)
    assert colors["plain"][0] < 0
    assert model.prototype_colors[0] == pytest.approx([0.2, 0.2, 0.2, 1], abs=2e-6)


def test_color_of_one_occurrence_overrides_all_others(read_here, tmp_path):
    document = make.Document()
    bolt = document.part(make.cylinder(), "bolt")
    document.color(bolt, make.rgba(0.2, 0.2, 0.2))
    pair = document.assembly("pair")
    left = document.component(pair, bolt, make.moved(100), "left")
    document.component(pair, bolt, make.moved(0, 50), "right")
    top = document.assembly("top")
    document.component(top, pair, make.moved(0, 0, 7), "pair_1")
    second = document.component(top, pair, make.moved(0, 0, 9), "pair_2")
    document.shapes.UpdateAssemblies()
    document.color_occurrence([second, left], bolt, make.rgba(1, 0, 0))
    path = document.write(tmp_path / "top.step")
    assert "OVER_RIDING_STYLED_ITEM" in path.read_text()
    model = read_here(path)
    colors = {instance.path[1:]: model.instance_colors[i] for i, instance in enumerate(model.instances)}
    assert colors.pop(("pair_2", "left")) == pytest.approx([1, 0, 0, 1], abs=2e-6)
    assert len(colors) == 3 and all(color[0] < 0 for color in colors.values())
    assert model.prototype_colors[0] == pytest.approx([0.2, 0.2, 0.2, 1], abs=2e-6)


def test_names_in_unicode_survive(read_here, tmp_path):
    document = make.Document()
    document.part(make.box(), "Schraube ø5 杯头")
    model = read_here(document.write(tmp_path / "name.step"))
    assert model.prototype_names == ("Schraube ø5 杯头",)


def test_missing_external_file_is_named(read_here, real_model, tmp_path):
    alone = tmp_path / "TAIL.stp"
    alone.write_bytes(real_model("stepcode+stepcode/TAIL.stp").read_bytes())
    (tmp_path / "TAIL_TURBINE.stp").write_bytes(real_model("stepcode+stepcode/TAIL_TURBINE.stp").read_bytes())
    model = read_here(alone)
    assert model.report["faces"] == 20
    missing = [i["entity"] for i in model.report["issues"] if i["severity"] == "error"]
    assert missing == ["TAIL_MIDDLE_PART.stp"]


def test_external_files_arrive(read_here, real_model):
    model = read_here(real_model("stepcode+stepcode/TAIL.stp"))
    assert model.report["faces"] == model.report["faces_in_file"] == 40
    assert model.report["face_uses"] == 60


def test_external_files_are_found_from_a_relative_path(read_here, tmp_path, monkeypatch):
    """OpenCascade looks for them beside the file only when it is given an absolute path."""
    folder = tmp_path / "assembly"
    folder.mkdir()
    make.step_file(folder / "inner.step", make.box())
    path = make.step_file(folder / "outer.step", make.box())
    make.refer_to_file(path, "inner.step")
    monkeypatch.chdir(tmp_path)
    absolute, relative = read_here(path), read_here("assembly/outer.step")
    assert absolute.report["issues"] == relative.report["issues"] == []
    assert relative.report["faces"] == 12


def test_lost_face_is_named_by_its_number(read_here, tmp_path):
    """A face whose surface is no surface: OCCT drops it without a word."""
    path = make.step_file(tmp_path / "box.step", make.box())
    text = path.read_text()
    lines = text.split(";")
    face = next(line for line in lines if "ADVANCED_FACE" in line)
    number = face.split("=")[0].strip()
    surface = face.split("),")[-1].split(",")[0].strip()
    broken = text.replace(f"{surface} = PLANE(", f"{surface} = CIRCLE(")
    assert broken != text
    path.write_text(broken)
    model = read_here(path)
    assert model.report["faces"] == 5
    lost = [i for i in model.report["issues"] if i["severity"] == "error"]
    assert number in [i["entity"] for i in lost]
    assert all(i["reason"] for i in lost)


def test_unused_surface_is_explained(read_here, real_model):
    with pytest.raises(EmptyError, match=r"#200 B_SPLINE_SURFACE.*16 control points but 12 weights"):
        read_here(real_model("dodgy-step-files/Gn002.stp"))
    with pytest.raises(EmptyError, match=r"#100 .*control point #21 is not a finite number"):
        read_here(real_model("dodgy-step-files/Gn010.stp"))


def test_tessellated_faces_are_noted(read_here, real_model):
    name = "yuechen-li-dev+Aetheris/nist_ftc_08_asme1_ap242-e1-tg.stp"
    report = read_here(real_model(name)).report
    assert report["faces"] == 273
    told = [i for i in report["issues"] if i["reason"].startswith("273 faces are given as triangles")]
    assert [(i["entity"], i["kind"], i["severity"]) for i in told] == [
        ("#141", "COMPLEX_TRIANGULATED_FACE", "note")
    ]
    assert not [i for i in report["issues"] if i["severity"] == "error"]


@pytest.mark.parametrize("heal", ["off", "strict"])
def test_healing_policies_keep_all_faces(read_here, real_model, heal):
    model = read_here(real_model("stepcode+stepcode/as1-oc-214.stp"), heal=heal)
    assert model.report["faces"] == 53 and model.report["face_uses"] == 160


def test_strict_reports_what_default_notes(read_here, real_model):
    path = real_model("partcad+partcad/AeroAssembly.step")
    default, strict = read_here(path).report["issues"], read_here(path, heal="strict").report["issues"]
    assert not [i for i in default if i["severity"] == "error"]
    assert [
        i for i in strict if i["severity"] == "error" and i["reason"].startswith("Edges were intersecting")
    ]


def test_strict_takes_an_added_seam_for_no_change(read_here, real_model):
    issues = read_here(real_model("CadQuery+cadquery/red_cube_blue_cylinder.step"), heal="strict").report[
        "issues"
    ]
    assert [(i["reason"], i["severity"]) for i in issues] == [("Missing seam-edge added", "note")]


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.95])
def test_truncated_file_is_an_error(read_here, tmp_path, keep):
    path = make.step_file(tmp_path / "box.step", make.box())
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * keep)])
    with pytest.raises(InputError, match="truncated"):
        read_here(path)


def test_schema_and_origin_are_facts_of_the_source(read_here, tmp_path):
    model = read_here(make.step_file(tmp_path / "box.step", make.box()))
    assert model.source["schema"].startswith("AUTOMOTIVE_DESIGN")
    assert "Open CASCADE" in model.source["preprocessor"] + model.source["originating_system"]
    assert Path(model.source["name"]).name == "box.step"


@pytest.mark.parametrize(
    "name",
    [
        "yuechen-li-dev+Aetheris/nist_stc_06_asme1_ap242-e3.stp",
        "CadQuery+cadquery/red_cube_blue_cylinder.step",
    ],
)
def test_unhealed_faces_lie_where_the_healed_ones_do(real_model, name):
    """Both files leave seams out, which healing adds; without it the loops are closed by the core."""
    pytest.importorskip("trimray._core")
    healed, raw = (trimray.load(real_model(name), heal=heal, cache=False) for heal in ("default", "off"))
    assert len(raw.faces) == len(healed.faces)
    assert all(face.status == "ok" for face in raw.faces)
    assert raw.bounds == pytest.approx(healed.bounds, abs=1e-6)
    depths = [np.asarray(model.render((200, 150), aovs="depth")["depth"]) for model in (healed, raw)]
    hit = np.isfinite(depths[0])
    assert hit.any() and (hit == np.isfinite(depths[1])).all()
    assert depths[1][hit] == pytest.approx(depths[0][hit], abs=1e-4)


@pytest.mark.parametrize(
    ("kind", "holder", "member"),
    [
        ("ADVANCED_FACE", "CLOSED_SHELL", "face"),
        ("MANIFOLD_SOLID_BREP", "ADVANCED_BREP_SHAPE_REPRESENTATION", "representation_item"),
        ("PLANE", "ADVANCED_FACE", "face_geometry"),
        ("NEXT_ASSEMBLY_USAGE_OCCURRENCE", "PRODUCT_DEFINITION_SHAPE", "definition"),
    ],
)
def test_what_a_record_names_and_does_not_get_is_an_error(
    read_here, samples_dir, tmp_path, kind, holder, member
):
    """OpenCascade leaves such a member out, and without a word of it the rest would pass as the whole."""
    text = (samples_dir / "assembly.step").read_text()
    records = re.findall(rf"(#\d+) = {kind}\(", text)
    lost = records[1]
    path = tmp_path / "lost.step"
    path.write_text(text.replace(f"{lost} = {kind}(", f"{lost} = UNKNOWN_RECORD("))
    issues = read_here(path).report["issues"]
    errors = [i for i in issues if i["severity"] == "error" and i["kind"] == member]
    assert [i["entity"] for i in errors] == [lost]
    assert errors[0]["reason"].startswith(holder) and "which it is not" in errors[0]["reason"]


def test_annotations_that_opencascade_does_not_know_are_no_loss(read_here, samples_dir, tmp_path):
    """In AP214 a draughting_callout is a geometric_representation_item, which a shape may hold."""
    text = (samples_dir / "assembly.step").read_text()
    solid = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\('[^']*',\((#\d+),", text)
    assert solid
    callout = "#999001 = LEADER_DIRECTED_CALLOUT('',(#11));\n"
    text = text[: solid.start(1)] + "#999001," + text[solid.start(1) :]
    head, end, tail = text.partition("ENDSEC;\nEND-ISO")
    path = tmp_path / "callout.step"
    path.write_text(head + callout + end + tail)
    issues = read_here(path).report["issues"]
    (found,) = [i for i in issues if i["entity"] == "#999001" and i["kind"] == "representation_item"]
    assert found["severity"] == "note" and "annotation" in found["reason"]
    assert not [i for i in issues if i["severity"] == "error"]


def test_members_are_found_as_parameters_and_in_lists():
    text = StepText(b"#1=A('x,(#9)',#2,(#3,\n#4),.T.);\n#5=B('',(#6,#7));")
    assert [text.member(1, k) for k in (2, 1, 3, 9)] == [2, 3, 0, 0]
    assert [text.member(5, k) for k in (1, 2, 3)] == [6, 7, 0]
    assert text.member(8, 1) == 0
