"""What every reader asks of OpenCascade: its switches, and the transfer into a document."""

from typing import Any

from OCP.IGESControl import IGESControl_Controller
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.Resource import Resource_DataMapOfAsciiStringAsciiString
from OCP.STEPCAFControl import STEPCAFControl_Controller
from OCP.STEPControl import STEPControl_Controller
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape
from OCP.XCAFApp import XCAFApp_Application

from .report import Report

# Operators of ShapeProcess "FixShape"; 0 at the upper levels switches everything below them off.
_FIX_MODES = (
    "FixShapeMode", "FixSolidMode", "FixFreeShellMode", "FixFreeFaceMode", "FixFreeWireMode",
    "FixSameParameterMode", "FixVertexPositionMode", "FixVertexToleranceMode", "FixFaceMode",
    "FixFaceOrientationMode", "FixShellMode", "FixShellOrientationMode", "FixWireMode", "FixTailMode",
)  # fmt: skip


_kept: list[Any] = []


def initialize() -> None:
    """Silences OpenCascade and registers the parameters of its STEP and IGES readers."""
    messenger = Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)
    STEPControl_Controller.Init_s()
    STEPCAFControl_Controller.Init_s()
    IGESControl_Controller.Init_s()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    Interface_Static.SetIVal_s("read.stepcaf.subshapes.name", 1)  # names of single faces
    Interface_Static.SetIVal_s("read.iges.onlyvisible", 0)


def set_precision(precision: float | None, unit_mm: float = 1.0) -> None:
    """precision: mm, or None for the file's own. unit_mm: of the unit in which the reader expects it."""
    Interface_Static.SetIVal_s("read.precision.mode", 0 if precision is None else 1)
    if precision is not None:
        Interface_Static.SetRVal_s("read.precision.val", precision / unit_mm)


def transfer(reader: Any, heal: str, report: Report) -> TDocStd_Document:
    """The document of what a STEPCAFControl_Reader or an IGESCAFControl_Reader has parsed.

    Neither is ever freed: freeing a document takes as long as extracting from it; the child ends anyway.
    """
    if heal == "off":
        _switch_healing_off(reader)
    document = new_document()
    _kept.extend((reader, document))
    with report.stage("transfer"):
        reader.Transfer(document)
    return document


def _switch_healing_off(reader: Any) -> None:
    parameters = Resource_DataMapOfAsciiStringAsciiString()
    for mode in _FIX_MODES:
        parameters.Bind(TCollection_AsciiString(f"FixShape.{mode}"), TCollection_AsciiString("0"))
    reader.SetShapeFixParameters(parameters)


def new_document() -> TDocStd_Document:
    """An empty XCAF document."""
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    XCAFApp_Application.GetApplication_s().NewDocument(TCollection_ExtendedString("MDTV-XCAF"), document)
    return document


def faces_of(shape: TopoDS_Shape) -> TopTools_IndexedMapOfShape:
    """The distinct faces (by TShape and location) of a shape."""
    faces = TopTools_IndexedMapOfShape()
    if not shape.IsNull():
        TopExp.MapShapes_s(shape, TopAbs_ShapeEnum.TopAbs_FACE, faces)
    return faces
