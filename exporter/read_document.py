"""A STEP file as OpenCascade's document of it, with all that its writer can write again."""

from __future__ import annotations

import signal
from pathlib import Path

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TDF import TDF_LabelSequence
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from trimray.importer.shapes import compound_of

from ..importer import occt
from ..importer.errors import EmptyError, InputError
from ..importer.read_step import PATIENCE_WITH_NAN, file_unit
from ..importer.report import Report
from ..importer.step_text import StepText
from .from_store import Rebuilt


def read_document(path: str, *, name: str, heal: str, precision: float | None, report: Report) -> Rebuilt:
    """Read as the importer does, but with layers and validation properties. Raises InputError."""
    if StepText(Path(path).read_bytes()).not_a_number():
        signal.alarm(PATIENCE_WITH_NAN)
    occt.set_precision(precision)
    reader = STEPCAFControl_Reader()
    for switch in ("Color", "Name", "Layer", "Props", "GDT", "Mat", "SHUO"):
        getattr(reader, f"Set{switch}Mode")(True)
    with report.stage("parse"):
        if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise InputError(f"{name}: not a readable STEP file")
    if heal == "off":
        occt.switch_healing_off(reader)
    document = occt.new_document()
    occt.keep(reader, document)
    with report.stage("transfer"):
        reader.Transfer(document)
    signal.alarm(0)
    unit, _ = file_unit(reader, report)
    labels = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(labels)
    world = compound_of([XCAFDoc_ShapeTool.GetShape_s(label) for label in labels])
    if occt.faces_of(world).Extent() == 0:
        raise EmptyError(f"{name}: no faces", report=report.as_dict())
    return Rebuilt(document, world, unit)
