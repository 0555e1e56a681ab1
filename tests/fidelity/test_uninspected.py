"""A model that OpenCascade could not inspect: what was not compared is told, and is not complete."""

from __future__ import annotations

import json
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any

import cadquery as cq
import pytest
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.TCollection import TCollection_ExtendedString
from OCP.XCAFDoc import XCAFDoc_DocumentTool

import trimray
from trimray.fidelity import Comparison
from trimray.fidelity.report_json import schema, to_json
from trimray.fidelity.report_junit import to_junit
from trimray.fidelity.report_text import to_text
from trimray.fidelity.result import Result, exit_code_of
from trimray.importer.occt import new_document
from trimray.testing import assert_same_geometry

from . import shapes
from .conftest import quick
from .validate import violations

CRASH = "OpenCascade crashed on it (SIGSEGV in stage 'measure')"


@pytest.fixture
def plate_file(tmp_path: Path) -> Path:
    path = tmp_path / "plate.step"
    cq.exporters.export(shapes.plate(), str(path))
    return path


@pytest.fixture
def crash(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the child that inspects."""

    def inspect(source: Any, *, name: str | None = None, **options: Any) -> trimray.Inspection:
        raise trimray.InputError(f"{Path(str(name or source)).name}: {CRASH}")

    monkeypatch.setattr(trimray, "inspect", inspect)


def lacking(comparison: Comparison) -> list[tuple[str, str, str]]:
    return [(f.section, f.name, f.reason) for f in comparison.differences() if f.uncompared]


def test_a_crash_of_the_inspection_is_told(crash: None, plate_file: Path) -> None:
    found = quick(plate_file, trimray.load(plate_file))
    assert found.verdict == "partial" and exit_code_of([found]) == 7
    assert lacking(found) == [("mass", "masses by OpenCascade", f"not compared: plate.step: {CRASH}")]
    assert [(f.a, f.b) for f in found.differences()] == [(False, True)]


def test_all_reports_name_what_was_not_compared(crash: None, plate_file: Path) -> None:
    results = [Result("plate.step", "compare", (quick(plate_file, plate_file),), exit_code=7)]
    text = to_text(results)
    assert " values not compared (default" in text.splitlines()[0] and "differ" not in text.splitlines()[0]
    assert "! masses by OpenCascade" in text and text.count(f"not compared: plate.step: {CRASH}") == 1
    read = json.loads(to_json(results))
    assert violations(read, schema()) == []
    (finding,) = [f for f in read["results"][0]["comparisons"][0]["findings"] if not f["same"]]
    assert (finding["a"], finding["b"], finding["missing"]) == (False, False, True)
    (failure,) = xml.fromstring(to_junit(results)).iter("failure")
    assert failure.get("type") == "not compared" and CRASH in str(failure.get("message"))


def test_an_assertion_fails_on_it(crash: None, plate_file: Path) -> None:
    with pytest.raises(AssertionError, match=r"1 of \d+ values not compared"):
        assert_same_geometry(plate_file, plate_file, size=(64, 64), views=["iso"])


def test_what_was_not_asked_for_lacks_nothing(crash: None, plate_file: Path) -> None:
    assert quick(plate_file, plate_file, inspect=False).verdict == "complete"


def test_triangles_have_nothing_to_inspect(tmp_path: Path) -> None:
    path = tmp_path / "ball.stl"
    cq.exporters.export(cq.Workplane().sphere(5), str(path))
    assert quick(path, path).verdict == "complete"


def test_models_of_which_nothing_can_be_drawn_are_not_complete() -> None:
    """Without bounds there are no distances and no pictures to compare."""
    side = trimray.fidelity.read(shapes.plate())
    side.__dict__["diagonal"] = 0.0
    found = quick(side, side)
    assert found.verdict == "partial"
    assert {(section, name) for section, name, _ in lacking(found)} == {
        ("geometry", "distances"),
        ("pictures", "pictures"),
    }


def test_layers_are_compared_without_an_inspection(tmp_path: Path) -> None:
    """They stand in the model itself."""
    files = []
    for name in ("pins", "bolts"):
        (tmp_path / name).mkdir()
        files.append(layered(tmp_path / name / "peg.step", name))
    assert quick(files[0], files[0], inspect=False).verdict == "complete"
    found = quick(*files, inspect=False)
    assert [(f.name, f.a, f.b, f.where) for f in found.differences()] == [
        ("layers", 1, 1, ""),
        ("layer", None, {"faces": 3, "instances": 0}, "bolts"),
        ("layer", {"faces": 3, "instances": 0}, None, "pins"),
    ]


def layered(path: Path, layer: str) -> Path:
    """A peg on a layer, written by OpenCascade."""
    document = new_document()
    peg = cq.Solid.makeCylinder(4, 20).wrapped
    part = XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).AddShape(peg, False)
    XCAFDoc_DocumentTool.LayerTool_s(document.Main()).SetLayer(part, TCollection_ExtendedString(layer, True))
    writer = STEPCAFControl_Writer()
    writer.SetLayerMode(True)
    assert writer.Transfer(document) and writer.Write(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    return path
