"""What could not be compared is told, and is not complete."""

from __future__ import annotations

import json
import xml.etree.ElementTree as xml
from pathlib import Path

import cadquery as cq
import pytest
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.TCollection import TCollection_ExtendedString
from OCP.XCAFDoc import XCAFDoc_DocumentTool

import trimray
from trimray.fidelity import Comparison, Side
from trimray.fidelity.report_json import schema, to_json
from trimray.fidelity.report_junit import to_junit
from trimray.fidelity.report_text import to_text
from trimray.fidelity.result import Result, exit_code_of
from trimray.fidelity.running import Running
from trimray.importer.occt import new_document
from trimray.testing import assert_same_geometry

from . import shapes
from .conftest import quick
from .validate import violations

WHY = "not compared: no face can be drawn"


@pytest.fixture
def undrawn() -> Side:
    """Without bounds there are no distances and no pictures to compare."""
    side = trimray.fidelity.read(shapes.plate())
    side.__dict__["diagonal"] = 0.0
    return side


def lacking(comparison: Comparison) -> list[tuple[str, str, str]]:
    return [(f.section, f.name, f.reason) for f in comparison.differences() if f.uncompared]


def test_models_of_which_nothing_can_be_drawn_are_not_complete(undrawn: Side) -> None:
    found = quick(undrawn, undrawn)
    assert found.verdict == "partial" and exit_code_of([found]) == 7
    assert lacking(found) == [("geometry", "distances", WHY), ("pictures", "pictures", WHY)]
    assert [(f.a, f.b) for f in found.differences()] == [(False, False)] * 2


def test_all_reports_name_what_was_not_compared(undrawn: Side) -> None:
    results = [Result("plate.step", "compare", (quick(undrawn, undrawn),), exit_code=7)]
    text = to_text(results)
    assert " values not compared (default" in text.splitlines()[0] and "differ" not in text.splitlines()[0]
    assert "! distances" in text and text.count(WHY) == 2
    read = json.loads(to_json(results))
    assert violations(read, schema()) == []
    first, _ = [f for f in read["results"][0]["comparisons"][0]["findings"] if not f["same"]]
    assert (first["a"], first["b"], first["missing"]) == (False, False, True)
    first, _ = xml.fromstring(to_junit(results)).iter("failure")
    assert first.get("type") == "not compared" and WHY in str(first.get("message"))


def test_an_assertion_fails_on_it(undrawn: Side, test_folder: Running) -> None:
    with pytest.raises(AssertionError, match=r"2 of \d+ values not compared"):
        assert_same_geometry(undrawn, undrawn, size=(64, 64), views=["iso"])
    assert len(test_folder.notes) == 1


def test_layers_are_compared(tmp_path: Path) -> None:
    """They stand in the model itself."""
    files = []
    for name in ("pins", "bolts"):
        (tmp_path / name).mkdir()
        files.append(layered(tmp_path / name / "peg.step", name))
    assert quick(files[0], files[0]).verdict == "complete"
    found = quick(*files)
    assert [(f.name, f.a, f.b, f.where) for f in found.differences()] == [
        ("layers", 1, 1, ""),
        ("layer", None, 3, "bolts"),
        ("layer", 3, None, "pins"),
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
