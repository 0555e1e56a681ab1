"""write: from a file, a shape and a store to STEP, IGES and BREP, in a child process."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder

import trimray.exporter
from trimray.importer import InputError, OutputError, TimeLimitError, UsageError

from .measure import store_of

# This process has OpenCascade already: its copies need not load it.
write = partial(trimray.exporter.write, start="fork")

SAMPLES = Path(__file__).resolve().parents[2] / "samples"


def outline(model):
    """What a model holds, apart from its geometry."""
    return (
        store_of(model).face_kinds(),
        [(node.name, node.parent, node.prototype, node.placement) for node in model.tree],
        model.prototype_names,
        model.prototype_colors.tolist(),
        model.unit,
    )


def test_an_assembly_goes_through_the_store_to_step_and_back(read_here, tmp_path):
    before = read_here(SAMPLES / "assembly.step")
    written = write(store_of(before), tmp_path / "out.step", via="step")
    assert written.issues == () and written.data is None
    assert written.size == (tmp_path / "out.step").stat().st_size
    assert outline(read_here(tmp_path / "out.step")) == outline(before)


@pytest.mark.parametrize("via", ["step", "iges", "brep"])
def test_every_format_holds_the_faces_of_a_store(read_here, tmp_path, via):
    before = read_here(SAMPLES / "torture" / "cylinder.step")
    written = write(store_of(before), via=via)
    assert written.path is None
    path = tmp_path / f"out.{via}"
    path.write_bytes(written.data)
    assert store_of(read_here(path)).face_kinds() == ["cylinder", "plane", "plane"]


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
    kinds = sorted(store_of(read_here(tmp_path / "b.step")).face_kinds())
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
