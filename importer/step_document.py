"""A STEP file as OpenCascade's document of it: what every reader of STEP does first."""

import signal
from collections.abc import Container

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TColStd import TColStd_SequenceOfAsciiString
from OCP.TDocStd import TDocStd_Document

from . import occt, units
from .errors import InputError
from .report import Report
from .sphere_seams import clear_seams
from .step_text import StepText

# Seconds for a file with coordinates that are not numbers.
_PATIENCE_WITH_NAN = 10

# What OpenCascade's reader can take over beside shapes.
_ALL_MODES = ("Color", "Name", "Layer", "Props", "GDT", "Mat", "View", "Meta", "ProductMeta", "SHUO")


def open_step(
    path: str,
    text: StepText,
    *,
    name: str,
    heal: str,
    precision: float | None,
    modes: Container[str],
    report: Report,
) -> tuple[STEPCAFControl_Reader, TDocStd_Document]:
    """The reader after its work, and what it made. text: of the file. modes: of _ALL_MODES, those that are
    wanted. Raises InputError."""
    if text.not_a_number():
        # OpenCascade may compute with it for ever: an alarm ends this process, and the caller says why.
        signal.alarm(_PATIENCE_WITH_NAN)
    occt.set_precision(precision)
    reader = STEPCAFControl_Reader()
    for mode in _ALL_MODES:
        getattr(reader, f"Set{mode}Mode")(mode in modes)
    with report.stage("parse"):
        status = reader.ReadFile(path)
        if status == IFSelect_ReturnStatus.IFSelect_RetDone:
            clear_seams(reader.ChangeReader().WS().Model(), text)
    if status != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(f"{name}: not a readable STEP file: {_parse_reason(reader)}")
    document = occt.transfer(reader, heal, report)
    signal.alarm(0)
    return reader, document


def file_unit(reader: STEPCAFControl_Reader, report: Report) -> tuple[str, float]:
    lengths, angles, solid_angles = (TColStd_SequenceOfAsciiString() for _ in range(3))
    reader.ChangeReader().FileUnits(lengths, angles, solid_angles)
    names = list(dict.fromkeys(length.ToCString() for length in lengths))
    if len(names) > 1:
        report.add("", "unit", f"several length units: {', '.join(names)}; the first is reported", "note")
    for name in names:
        known = units.unit_of(name)
        if known is not None:
            return known
        report.add("", "unit", f"unknown length unit '{name}'", "warning")
    return "mm", 1.0


def _parse_reason(reader: STEPCAFControl_Reader) -> str:
    model = reader.ChangeReader().WS().Model()
    if model is not None:
        check = model.GlobalCheck()
        if check.NbFails():
            return str(check.CFail(1))
    return "syntax error"
