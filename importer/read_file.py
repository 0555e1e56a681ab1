"""Reads one file of any kind, in the process that calls it (the child); imports OCP."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import archive, complete, occt
from .errors import EmptyError, InputError
from .extract import build_model
from .formats import kSniffBytes, sniff
from .model import BrepModel
from .read_brep import read_brep
from .read_iges import read_iges
from .read_step import read_step
from .report import Report
from .scene import Scene


def read_file(
    path: str,
    *,
    name: str,
    folder: str,
    heal: str = "default",
    precision: float | None = None,
    memory_limit: int | None = None,
    on_stage: Callable[[str], None] | None = None,
) -> BrepModel:
    """As reader.read_model, for an existing file. folder: scratch space. Raises InputError and its kin."""
    report = Report(on_stage=on_stage)
    occt.initialize()
    source: dict[str, Any] = {"name": os.path.basename(name), "bytes": os.path.getsize(path)}
    kind, inner = _kind(path, name), name
    if kind in ("gzip", "zip"):
        with report.stage("unpack"):
            unpacked, inner = archive.unpack(
                Path(path), kind, Path(folder), name=name, memory_limit=memory_limit
            )
        path = str(unpacked)
        source["archive"], source["member"] = kind, inner
        kind = _kind(path, inner)
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
        raise InputError(f"{name}: not a STEP, IGES or BREP file")
    if not scene.placed:
        raise EmptyError(f"{name}: no faces{_first_reason(report)}", report=report.as_dict())
    _name_roots(scene, Path(name).stem)
    if heal == "off" or kind in ("brep", "binbrep"):
        with report.stage("heal"):
            complete.add_missing_curves(scene, report)
    if heal == "strict":
        with report.stage("heal"):
            complete.check_faces(scene, report, precision)
    return build_model(scene, report, unit=unit, unit_mm=unit_mm, source={**source, **facts})


def _name_roots(scene: Scene, stem: str) -> None:
    """What stands at the root without a name is called like the file."""
    for node in scene.nodes:
        if node.parent < 0 and not node.name:
            node.name = stem
            if node.part >= 0 and not scene.parts[node.part].name:
                scene.parts[node.part].name = stem


def _kind(path: str, name: str) -> Any:
    with open(path, "rb") as file:
        return sniff(file.read(kSniffBytes), name)


def _first_reason(report: Report) -> str:
    errors = [issue for issue in report.issues if issue.severity == "error"]
    for issue in errors or [i for i in report.issues if i.severity == "warning"]:
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        return f": {issue.entity} {issue.kind}: {issue.reason}{more}"
    return ""
