"""IGES files: trimmed and loose surfaces, and B-rep solids. IGES keeps edges apart, so faces are sewn."""

from pathlib import Path
from typing import Any

from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESCAFControl import IGESCAFControl_Reader

from . import iges_text, occt, units, xcaf
from .errors import InputError
from .iges_report import IgesAudit
from .loose import merge_loose
from .report import Report
from .scene import Scene
from .sew import sew_part

# Sewing tolerance where the caller names none: what CAD systems knit within (but no more than a small part of
# the diagonal), or the file's own resolution where that is coarser.
_KNIT_MM = 0.01
_KNIT_PART = 5e-5
_MOST_PART = 1e-4


def read_iges(
    path: str, *, name: str, heal: str, precision: float | None, folder: str, report: Report
) -> tuple[Scene, str, float, dict[str, Any]]:
    """Like read_step. folder: where a repaired copy of a sloppy file goes."""
    report.format = "iges"
    text = iges_text.parse(Path(path).read_bytes())
    if text.truncated:
        raise InputError(f"{name}: truncated: {text.truncated}")
    if not text.directory:
        raise InputError(f"{name}: no entity in the directory section")
    if text.problems:
        for problem in text.problems:
            report.add("", "file", f"repaired: {problem}", "warning")
        path = str(Path(folder) / "repaired.igs")
        Path(path).write_bytes(iges_text.rewrite(text))
    reader = IGESCAFControl_Reader()
    reader.SetColorMode(True)
    reader.SetNameMode(True)
    reader.SetLayerMode(True)
    with report.stage("parse"):
        status = reader.ReadFile(path)
    if status != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise InputError(f"{name}: not a readable IGES file")
    header = reader.IGESModel().GlobalSection()
    unit_mm = header.UnitValue()
    occt.set_precision(precision, unit_mm)
    document = occt.transfer(reader, heal, report)
    with report.stage("extract"):
        scene, without_faces = xcaf.read_document(document)
        report.add_curves(without_faces)
        arrived = len({face.TShape() for part in scene.parts for face in occt.faces_of(part.shape)})
        IgesAudit(reader, text, report, changed="error" if heal == "strict" else "note").run(arrived)
    with report.stage("sew"):
        scene = merge_loose(scene, Path(name).stem)
        for part in scene.parts:
            sew_part(part, precision or _sewing_tolerance(part.shape, header.Resolution() * unit_mm), report)
    facts = {"originating_system": _text(header.SystemId()), "preprocessor": _text(header.InterfaceVersion())}
    return scene, units.name_of(unit_mm), unit_mm, {key: value for key, value in facts.items() if value}


def _sewing_tolerance(shape: Any, resolution: float) -> float:
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    diagonal = 1.0 if box.IsVoid() or box.IsOpen() else max(box.SquareExtent() ** 0.5, 1e-9)
    return float(min(max(resolution, min(_KNIT_MM, _KNIT_PART * diagonal)), _MOST_PART * diagonal))


def _text(value: Any) -> str:
    return str(value.ToCString()) if value is not None else ""
