"""write: from a file, a shape and a store to STEP, IGES and BREP, in a child process."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder

import trimray.exporter
from trimray import _core, inspect
from trimray.importer import InputError, OutputError, TimeLimitError, UsageError, shapes
from trimray.importer.build_store import build_store

# This process has OpenCascade already: its copies need not load it.
write = partial(trimray.exporter.write, start="fork")

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


def outline(model):
    """What a model holds, apart from its geometry."""
    return (
        build_store(model).face_kinds(),
        [(node.name, node.parent, node.prototype, node.placement) for node in model.tree],
        model.prototype_names,
        model.prototype_colors.tolist(),
        model.unit,
    )


def test_an_assembly_goes_through_the_store_to_step_and_back(read_here, tmp_path):
    before = read_here(SAMPLES / "assembly.step")
    written = write(build_store(before), tmp_path / "out.step", via="step")
    assert written.issues == () and written.data is None
    assert written.size == (tmp_path / "out.step").stat().st_size
    assert outline(read_here(tmp_path / "out.step")) == outline(before)


@pytest.mark.parametrize("via", ["step", "iges", "brep"])
def test_every_format_holds_the_faces_of_a_store(read_here, tmp_path, via):
    before = read_here(SAMPLES / "torture" / "cylinder.step")
    written = write(build_store(before), via=via)
    assert written.path is None
    path = tmp_path / f"out.{via}"
    path.write_bytes(written.data)
    assert build_store(read_here(path)).face_kinds() == ["cylinder", "plane", "plane"]


@pytest.mark.parametrize(
    ("schema", "said"),
    [("ap203", b"CONFIG_CONTROL_DESIGN"), ("ap214", b"AUTOMOTIVE_DESIGN"), ("ap242", b"AP242")],
)
def test_the_schema_is_the_one_asked_for(schema, said):
    data = write(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), schema=schema).data
    assert said in data[: data.index(b"DATA;")]


def test_a_shape_and_a_file_are_written_too(read_here, tmp_path):
    write(BRepPrimAPI_MakeCylinder(2.0, 5.0).Shape(), tmp_path / "a.brep", via="brep")
    write(tmp_path / "a.brep", tmp_path / "b.step")
    kinds = sorted(build_store(read_here(tmp_path / "b.step")).face_kinds())
    assert kinds == ["cylinder", "plane", "plane"]


def test_wrong_words_and_files_are_one_clear_line(tmp_path):
    with pytest.raises(UsageError, match="'stl' is not one of step, iges, brep"):
        write(SAMPLES / "patch.step", via="stl")
    with pytest.raises(UsageError, match="'ap999' is not one of"):
        write(SAMPLES / "patch.step", schema="ap999")
    with pytest.raises(UsageError, match="no B-rep to write"):
        write(SAMPLES / "stand.stl")
    with pytest.raises(InputError, match="empty"):
        write(b"")
    with pytest.raises(OutputError, match="No such file"):
        write(SAMPLES / "patch.step", tmp_path / "missing" / "out.step")
    assert list(tmp_path.iterdir()) == []


def test_a_limit_ends_the_writing(tmp_path):
    with pytest.raises(TimeLimitError, match=r"not written within 0\.01 s"):
        write(SAMPLES / "patch.step", tmp_path / "out.step", time_limit=0.01)
    assert list(tmp_path.iterdir()) == []


def test_a_placed_part_keeps_its_place_name_and_colours(read_here, tmp_path):
    cadquery = pytest.importorskip("cadquery")
    assembly = cadquery.Assembly(
        cadquery.Workplane().box(1, 2, 3),
        name="brick",
        loc=cadquery.Location((5, 6, 7), (0, 0, 1), 30),
        color=cadquery.Color(0.5, 0.25, 0.125, 1.0),
    )
    written = write(assembly, tmp_path / "out.step")
    assert written.issues == ()  # an assembly of its own holds it
    before, after = shapes.from_shape(assembly), read_here(tmp_path / "out.step")
    assert np.allclose(after.instance_placements, before.instance_placements, atol=1e-12)
    assert np.allclose(after.instance_colors, before.instance_colors, atol=1e-6)
    assert [node.name for node in after.tree] == ["brick", "brick"]


def test_parts_may_say_their_volume_and_area(tmp_path):
    data = write(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), properties=True).data.decode()
    assert measure(data, "VOLUME_MEASURE") == pytest.approx(6.0)
    assert measure(data, "AREA_MEASURE") == pytest.approx(22.0)


def test_what_parts_say_of_themselves_holds(tmp_path):
    """Where OpenCascade's own integration is off by 1.5e-3."""
    path = tmp_path / "out.step"
    write(SAMPLES / "torture" / "extruded_spline.step", path, properties=True)
    found = inspect(path)
    assert {one.quantity for one in found.properties} == {"volume", "area", "centroid"}
    assert max(one.relative for one in found.properties) < 1e-9


def measure(text, kind):
    return float(text.split(f"{kind}(", 1)[1].split(")", 1)[0])


def test_faces_of_triangles_go_through_brep(read_here, tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float64)
    sides = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
    colors = np.array([[0.5, 0.25, 0.75, 1.0]], dtype=np.float32)
    store = _core.Store.from_triangles(points, sides, np.array([4], dtype=np.int32), colors, "{}")
    write(store, tmp_path / "out.brep", via="brep")
    arrays = build_store(read_here(tmp_path / "out.brep")).arrays()
    assert np.array_equal(arrays["mesh_vertices"], points)
    assert np.array_equal(arrays["mesh_triangles"], sides)


def test_arrays_share_the_memory_of_their_store_and_cannot_be_written(read_here):
    arrays = build_store(read_here(SAMPLES / "torture" / "cylinder.step")).arrays()
    assert arrays["surfaces"]["r1"].max() > 0.0  # the store lives on in its arrays
    filled = [array for array in arrays.values() if array.size]
    assert len(filled) >= 12
    assert not any(array.flags.writeable or array.flags.owndata for array in filled)
    assert arrays["faces"].dtype["uv_box"].shape == (2, 2)
