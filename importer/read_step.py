"""STEP files: AP203, AP214, AP242, with the files they refer to."""

import os
import signal
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TColStd import TColStd_SequenceOfAsciiString

from . import occt, units, xcaf
from .errors import InputError
from .report import Report
from .scene import Scene
from .step_report import StepAudit
from .step_text import StepText

# Seconds for a file with coordinates that are not numbers.
PATIENCE_WITH_NAN = 10


def read_step(
    path: str, *, name: str, heal: str, precision: float | None, report: Report
) -> tuple[Scene, str, float, dict[str, Any]]:
    """The scene, the unit's name, its size in mm, and facts of the source. Raises InputError."""
    data = Path(path).read_bytes()
    text = StepText(data)
    report.format = "step"
    broken = text.broken_off()
    if broken:
        raise InputError(f"{name}: {broken}")
    if broken == "":
        report.add("", "file", "the closing END-ISO-10303-21 is missing", "warning")
    if text.not_a_number():
        # OpenCascade may compute with it for ever: an alarm ends this process, and the caller says why.
        signal.alarm(PATIENCE_WITH_NAN)
    occt.set_precision(precision)
    reader = STEPCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    reader.SetLayerMode(True)
    for switch in ("Props", "GDT", "Mat", "View", "Meta", "ProductMeta"):
        getattr(reader, f"Set{switch}Mode")(False)
    reader.SetSHUOMode(True)
    with report.stage("parse"):
        status = reader.ReadFile(path)
    if status != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(f"{name}: not a readable STEP file: {_parse_reason(reader)}")
    if heal == "off":
        occt.switch_healing_off(reader)
    document = occt.new_document()
    occt.keep(reader, document)
    with report.stage("transfer"):
        reader.Transfer(document)
    signal.alarm(0)
    with report.stage("extract"):
        scene, without_faces = xcaf.read_document(document)
        if without_faces:
            report.add("", "shape", f"{without_faces} shapes are curves or points: not drawn", "note")
        externals = _external_texts(Path(path).parent, text, report)
        report.faces_in_file = sum(
            len(t.faces) + len(t.loose_surfaces) + len(t.tessellated) for t in (text, *externals)
        )
        arrived = _distinct_faces(scene)
        scene.session = reader.ChangeReader().WS()
        audit = StepAudit(scene.session, text, report, changed="error" if heal == "strict" else "note")
        audit.load()
        outside = sum(len(t.faces) + len(t.loose_surfaces) for t in externals)
        audit.transfer(max(0, arrived - outside))
        unit, unit_mm = file_unit(reader, report)
    return scene, unit, unit_mm, text.header()


def _distinct_faces(scene: Scene) -> int:
    return len({face.TShape() for part in scene.parts for face in occt.faces_of(part.shape)})


def _external_texts(folder: Path, text: StepText, report: Report) -> list[StepText]:
    """The texts of all files that ``text`` refers to, directly or not; missing ones are reported."""
    found: dict[str, StepText] = {}
    queue = list(text.external_files)
    while queue:
        reference = queue.pop(0)
        if reference in found:
            continue
        path = folder / reference.replace("\\", "/")
        if not path.is_file():
            path = folder / os.path.basename(reference.replace("\\", "/"))
        try:
            inner = StepText(path.read_bytes())
        except OSError as error:
            report.add(reference, "external reference", f"cannot be read: {error.strerror or error}")
            continue
        found[reference] = inner
        queue.extend(inner.external_files)
    return list(found.values())


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
