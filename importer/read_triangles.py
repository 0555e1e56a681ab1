"""Reads a file of triangles (STL, OBJ, PLY, OFF), in the process that calls it (the child). It
needs the native core, and no OpenCascade."""

from pathlib import Path

from .. import _core
from .errors import EmptyError, InputError
from .input_file import InputFile
from .mesh_model import MeshModel
from .report import Report


def read_triangles(file: InputFile, *, name: str, report: Report) -> MeshModel:
    """Raises InputError for a damaged file, EmptyError where it holds no triangle."""
    report.format = file.kind
    try:
        with report.stage("triangles"):
            mesh = _core.read_mesh_file(file.path, file.kind)
    except _core.FormatError as error:
        raise InputError(f"{name}: {file.kind.upper()}: {error}") from None
    if mesh.left_out:
        report.add("", "triangle", f"{mesh.left_out} of {mesh.faces} faces have no area: left out", "note")
    if mesh.mixed_colors:
        report.add("", "color", "too many colours: drawn in their mean", "warning")
    report.add("", "unit", "the format has no unit: lengths are taken as mm", "note")
    triangles = mesh.triangles()
    if not len(triangles):
        raise EmptyError(f"{name}: no triangles", report=report.as_dict())
    ends = mesh.group_ends()
    report.faces = report.face_uses = len(ends)
    vertices = mesh.vertices()
    facts = {
        "format": file.kind,
        "binary": mesh.binary,
        "triangles": len(triangles),
        "vertices": len(vertices),
    }
    return MeshModel(
        vertices=vertices,
        triangles=triangles,
        group_ends=ends,
        group_colors=mesh.group_colors(),
        group_names=tuple(_text(raw) for raw in mesh.group_names()),
        name=Path(name).stem,
        source={**file.source, **facts},
        report=report.as_dict(),
    )


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace").replace("\0", "").strip()
