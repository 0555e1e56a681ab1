"""No false alarms: equal models that came by different ways."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cadquery as cq
import pytest

import trimray
from trimray.importer.occt import initialize

from . import shapes
from .conftest import quick

Load = Callable[[Path], trimray.Model]

SAMPLES = [
    "bracket.step",
    "assembly.step",
    "spline_part.step",
    "patch.step",
    "cornell_box.step",
    "teapot.step",
    "torture/nurbs_solids.step",
    "torture/hole_on_seam.step",
    "torture/pole_cut.step",
    "torture/helix_thread.step",
    "torture/thick_shell.step",
    "torture/far_away.step",
    "torture/tiny.step",
    "torture/huge.step",
]


def clean(a: Any, b: Any, **options: Any) -> None:
    found = quick(a, b, **options)
    assert [(f.section, f.name, f.a, f.b, f.where, f.reason) for f in found.differences()] == []
    assert found.verdict == "complete"
    assert len({f.section for f in found.findings}) == 6


@pytest.mark.parametrize(
    "shape",
    [shapes.plate, shapes.pair, shapes.four_pegs, shapes.spline_face],
    ids=lambda make: make.__name__,
)
def test_the_same_shape_twice(shape: Callable[[], Any]) -> None:
    clean(shape(), shape(), profile="strict")


def rewrite(source: Path, target: Path, kind: str = "step") -> None:
    """By OpenCascade, with names, colours and tree."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESCAFControl import IGESCAFControl_Writer
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Reader, STEPCAFControl_Writer

    from trimray.importer.occt import new_document

    initialize()
    document = new_document()
    reader = STEPCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    assert reader.ReadFile(str(source)) == IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.Transfer(document)
    if kind == "iges":
        iges = IGESCAFControl_Writer()
        assert iges.Transfer(document)
        iges.ComputeModel()
        assert iges.Write(str(target))
        return
    writer = STEPCAFControl_Writer()
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    assert writer.Transfer(document)
    assert writer.Write(str(target)) == IFSelect_ReturnStatus.IFSelect_RetDone


@pytest.mark.parametrize("name", SAMPLES)
def test_step_rewritten_by_opencascade(name: str, samples_dir: Path, tmp_path: Path, load_here: Load) -> None:
    rewrite(samples_dir / name, tmp_path / "again.step")
    clean(load_here(samples_dir / name), load_here(tmp_path / "again.step"))


def test_a_shape_and_its_step_file(tmp_path: Path, load_here: Load) -> None:
    """The shape has no name, its file has one that OpenCascade made up."""
    cq.exporters.export(shapes.plate(), str(tmp_path / "plate.step"))
    clean(shapes.plate(), load_here(tmp_path / "plate.step"))


def test_an_assembly_and_its_step_file(tmp_path: Path, load_here: Load) -> None:
    shapes.pair().export(str(tmp_path / "pair.step"))
    clean(shapes.pair(), load_here(tmp_path / "pair.step"))


def test_brep_and_step_of_one_shape(samples_dir: Path, load_here: Load) -> None:
    clean(load_here(samples_dir / "bracket.step"), load_here(samples_dir / "bracket.brep"))


def test_iges_and_step_of_one_shape(samples_dir: Path, load_here: Load) -> None:
    clean(load_here(samples_dir / "bracket.step"), load_here(samples_dir / "bracket_solid.igs"))


def test_an_assembly_in_a_format_without_a_tree(tmp_path: Path, load_here: Load) -> None:
    """All parts are one there; where they touch, faces of both lie in one place."""
    pair = shapes.pair(places=(0.0, 20.0))
    solids = cq.Compound.makeCompound([solid for child in pair.children for solid in moved_solids(child)])
    cq.exporters.export(cq.Workplane(solids), str(tmp_path / "pair.brep"), "BREP")
    found = quick(pair, load_here(tmp_path / "pair.brep"))
    assert [(f.section, f.name, f.where) for f in found.differences()] == []
    assert any(f.reason == "not compared: brep holds none" and f.name == "tree" for f in found.findings)


def moved_solids(child: Any) -> list[Any]:
    return [shape.moved(child.loc) for shape in child.shapes]


def test_faces_in_another_order() -> None:
    box = cq.Workplane().box(*shapes.BOX)
    clean(shapes.shell_of(box), shapes.shell_of(box, order=-1))


def test_reordered_entities(tmp_path: Path, load_here: Load) -> None:
    """The lines of a file in the opposite order."""
    cq.exporters.export(shapes.plate(), str(tmp_path / "plate.step"))
    text = (tmp_path / "plate.step").read_text()
    head, rest = text.split("DATA;\n", 1)
    data, tail = rest.split("ENDSEC;", 1)
    entities = [entity for entity in data.split(";\n") if entity.strip()]
    turned = head + "DATA;\n" + "".join(f"{entity};\n" for entity in entities[::-1]) + "ENDSEC;" + tail
    (tmp_path / "turned.step").write_text(turned)
    clean(load_here(tmp_path / "plate.step"), load_here(tmp_path / "turned.step"))
