"""Writes a document as a STEP, IGES or BREP file, in the process that calls it (the child)."""

from __future__ import annotations

from typing import Any

from OCP.BRepTools import BRepTools
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESCAFControl import IGESCAFControl_Writer
from OCP.Interface import Interface_Static
from OCP.STEPCAFControl import STEPCAFControl_Writer

from ..importer.errors import OutputError
from .document import Writable
from .names import restore_names

SCHEMAS = {"ap203": "AP203", "ap214": "AP214IS", "ap242": "AP242DIS"}
# Our names of units (importer/units.py) in OpenCascade's words; for all others the file is in mm.
_UNITS = {
    "mm": "MM", "cm": "CM", "m": "M", "km": "KM", "um": "UM", "inch": "INCH", "ft": "FT", "mi": "MI",
    "mil": "MIL", "uin": "UIN",
}  # fmt: skip


def write_file(model: Writable, path: str, via: str, schema: str, *, faithful: bool = False) -> None:
    """Raises OutputError.

    faithful: mend what OpenCascade loses in STEP files where it can be mended. The file's uncertainty is the
        greatest tolerance, not the average: its reader makes new p-curves for all edges that miss theirs
        by more than that. Components keep their own names.
    """
    if via == "brep":
        done = BRepTools.Write_s(model.world, path)
    elif via == "iges":
        done = _write_iges(model, path)
    else:
        done = _write_step(model, path, schema, faithful)
    if not done:
        raise OutputError(f"{path}: OpenCascade cannot write this model as {via.upper()}")


def _write_step(model: Writable, path: str, schema: str, faithful: bool) -> bool:
    _set("write.step.schema", SCHEMAS[schema])
    _set("write.step.unit", _UNITS.get(model.unit, "MM"))
    _set("write.surfacecurve.mode", 1)
    _set("write.precision.mode", 1 if faithful else 0)
    _set("write.stepcaf.subshapes.name", 1)
    if _step_written(model, path, faithful, tolerances=True):
        return True
    if not _step_written(model, path, faithful, tolerances=False):
        return False
    model.issues.append((-1, "OpenCascade cannot write the dimensions and tolerances (PMI) of this file"))
    return True


def _step_written(model: Writable, path: str, faithful: bool, *, tolerances: bool) -> bool:
    writer = STEPCAFControl_Writer()
    for switch in ("Color", "Name", "Layer", "Props", "Material", "SHUO"):
        getattr(writer, f"Set{switch}Mode")(True)
    writer.SetDimTolMode(tolerances)
    if not writer.Transfer(model.document):
        return False
    if faithful:
        restore_names(writer.ChangeWriter().Model(False), model.document)
    return bool(writer.Write(path) == IFSelect_ReturnStatus.IFSelect_RetDone)


def _write_iges(model: Writable, path: str) -> bool:
    _set("write.iges.unit", _UNITS.get(model.unit, "MM"))
    _set("write.iges.brep.mode", 1)
    writer = IGESCAFControl_Writer()
    for switch in ("Color", "Name", "Layer"):
        getattr(writer, f"Set{switch}Mode")(True)
    if not writer.Transfer(model.document):
        return False
    writer.ComputeModel()
    return bool(writer.Write(path))


def _set(name: str, value: Any) -> None:
    set_value = Interface_Static.SetIVal_s if isinstance(value, int) else Interface_Static.SetCVal_s
    if not set_value(name, value):
        raise OutputError(f"OpenCascade does not take {value} for {name}")
