"""Reads one file of any kind, in the process that calls it (the child); imports OCP."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import complete, occt
from .errors import EmptyError, InputError
from .extract import build_model
from .input_file import InputFile, open_input
from .model import BrepModel
from .read_brep import read_brep
from .read_iges import read_iges
from .read_step import read_step
from .report import Report
from .scene import Scene


@dataclass(frozen=True)
class ReadScene:
    """A scene and what is known of its file. unit_mm: size of its unit. source: as of BrepModel."""

    scene: Scene
    unit: str
    unit_mm: float
    source: dict[str, Any]


def read_file(
    path: str,
    *,
    name: str,
    folder: str,
    heal: str = "default",
    precision: float | None = None,
    memory_limit: int | None = None,
    on_stage: Callable[[str], None] | None = None,
    opened: InputFile | None = None,
    report: Report | None = None,
) -> BrepModel:
    """As reader.read_model, for an existing file of a B-rep. folder: scratch space. opened: what open_input
    said of it, with its report. Raises InputError and its kin."""
    report = report or Report(on_stage=on_stage)
    if opened is None:
        opened = open_input(path, name=name, folder=folder, memory_limit=memory_limit, report=report)
    read = read_scene(opened, name=name, folder=folder, heal=heal, precision=precision, report=report)
    return build_model(read.scene, report, unit=read.unit, unit_mm=read.unit_mm, source=read.source)


def read_scene(
    opened: InputFile, *, name: str, folder: str, heal: str, precision: float | None, report: Report
) -> ReadScene:
    """As read_file, before the shapes are written."""
    occt.initialize()
    path, kind = opened.path, opened.kind
    if kind == "step":
        scene, unit, unit_mm, facts = read_step(
            path, name=name, heal=heal, precision=precision, report=report
        )
    elif kind == "iges":
        scene, unit, unit_mm, facts = read_iges(
            path, name=name, heal=heal, precision=precision, folder=folder, report=report
        )
    elif kind in ("brep", "binbrep"):
        scene, unit, unit_mm, facts = read_brep(path, name=name, binary=kind == "binbrep", report=report)
    else:
        raise InputError(f"{name}: not a STEP, IGES or BREP file, nor triangles (STL, OBJ, PLY, OFF)")
    if not scene.placed:
        raise EmptyError(f"{name}: no faces{_first_reason(report)}", report=report.as_dict())
    _name_roots(scene, Path(name).stem)
    if heal == "off" or kind in ("brep", "binbrep"):
        with report.stage("heal"):
            complete.add_missing_curves(scene, report)
    if heal == "strict":
        with report.stage("heal"):
            complete.check_faces(scene, report, precision)
    return ReadScene(scene, unit, unit_mm, {**opened.source, **facts})


def _name_roots(scene: Scene, stem: str) -> None:
    """What stands at the root without a name is called like the file."""
    for node in scene.nodes:
        if node.parent < 0 and not node.name:
            node.name = stem
            if node.part >= 0 and not scene.parts[node.part].name:
                scene.parts[node.part].name = stem


def _first_reason(report: Report) -> str:
    errors = [issue for issue in report.issues if issue.severity == "error"]
    for issue in errors or [i for i in report.issues if i.severity == "warning"]:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        return f": {issue.entity} {issue.kind}: {issue.reason}{more}"
    return next((f": {issue.reason}" for issue in report.issues if issue.kind == "shape"), "")
