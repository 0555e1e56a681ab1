"""OpenCascade's own files: .brep, as text or binary."""

import re
from pathlib import Path
from typing import Any

from OCP.BinTools import BinTools
from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools
from OCP.TopoDS import TopoDS_Shape

from .errors import InputError
from .report import Report
from .scene import Scene
from .shapes import scene_of_shape


def read_brep(
    path: str, *, name: str, binary: bool, report: Report
) -> tuple[Scene, str, float, dict[str, Any]]:
    """Like read_step; the file knows no unit, so lengths are taken as mm."""
    report.format = "brep"
    if not binary and not _is_complete(Path(path).read_bytes()):
        raise InputError(f"{name}: truncated: its shapes are not all there")
    shape = TopoDS_Shape()
    with report.stage("parse"):
        done = BinTools.Read_s(shape, path) if binary else BRepTools.Read_s(shape, path, BRep_Builder())
    if not done or shape.IsNull():
        raise InputError(f"{name}: not a readable BREP file")
    with report.stage("extract"):
        scene = scene_of_shape(shape)
        report.add_curves(0 if scene.placed else 1)
        return scene, "mm", 1.0, {}


def _is_complete(data: bytes) -> bool:
    """Whether a text file holds the shapes it announces; OpenCascade hangs on one that lacks some."""
    match = re.search(rb"\nTShapes (\d+)\s", data)
    return match is not None and data.count(b"*", match.end()) >= int(match[1])
