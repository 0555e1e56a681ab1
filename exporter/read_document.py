"""A STEP file as OpenCascade's document of it, with all that its writer can write again."""

from __future__ import annotations

from pathlib import Path

from OCP.TDF import TDF_LabelSequence
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from ..importer import occt
from ..importer.errors import EmptyError
from ..importer.report import Report
from ..importer.shapes import compound_of
from ..importer.step_document import file_unit, open_step
from ..importer.step_text import StepText
from .document import Writable

# What the writer can write again.
_MODES = ("Color", "Name", "Layer", "Props", "GDT", "Mat", "View", "Meta", "SHUO")


def read_document(path: str, *, name: str, heal: str, precision: float | None, report: Report) -> Writable:
    """Read as the importer does, but with materials, tolerances and properties. Raises InputError."""
    text = StepText(Path(path).read_bytes())
    reader, document = open_step(
        path, text, name=name, heal=heal, precision=precision, modes=_MODES, report=report
    )
    unit, _ = file_unit(reader, report)
    labels = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(labels)
    world = compound_of([XCAFDoc_ShapeTool.GetShape_s(label) for label in labels])
    if occt.faces_of(world).Extent() == 0:
        raise EmptyError(f"{name}: no faces", report=report.as_dict())
    return Writable(document, world, unit)
