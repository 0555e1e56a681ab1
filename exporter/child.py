"""The process that writes one file, alone with OpenCascade: a crash, a hang or a full memory ends only it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from ..importer import wire
from ..importer.child import serve
from ..importer.errors import UsageError
from ..importer.formats import TRIANGLES
from ..importer.input_file import open_input
from ..importer.report import Report

if TYPE_CHECKING:
    from .document import Writable


def main(argument: str) -> None:
    """argument: JSON of write.WriteRequest, with what child.serve wants."""
    serve(argument, _write)


def _write(request: dict[str, Any], pipe: BinaryIO) -> None:
    report = Report(on_stage=lambda stage: wire.send(pipe, {"stage": stage, "fraction": None}))
    model = _model(request, report)
    if request["properties"] and request["via"] == "step":
        from .properties import add_properties

        with report.stage("measure"):
            add_properties(model.document)
    with report.stage("write"):
        from .files import write_file

        store = request["source"] == "store"
        write_file(model, request["target"], request["via"], request["schema"], faithful=store)
    answer = {
        "issues": model.issues,
        "seconds": report.as_dict()["seconds"],
        "bytes": os.path.getsize(request["target"]),
    }
    wire.send(pipe, {"answer": answer})


def _model(request: dict[str, Any], report: Report) -> Writable:
    path, name = request["path"], request["name"]
    with report.stage("load"):
        from ..importer import occt

        occt.initialize()
    if request["source"] == "store":
        from .. import _core
        from .from_store import rebuild

        with report.stage("rebuild"):
            store = _core.Store.load(Path(path).read_bytes())
            return rebuild(store.arrays(), store.meta)
    from .from_model import document_of, load_model

    if request["source"] == "model":
        with report.stage("rebuild"):
            return document_of(load_model(Path(path)))
    opened = open_input(
        path, name=name, folder=request["folder"], memory_limit=request["memory_limit"], report=report
    )
    if opened.kind in TRIANGLES:
        raise UsageError(f"{name}: triangles: there is no B-rep to write")
    options = {"name": name, "heal": request["heal"], "precision": request["precision"], "report": report}
    if opened.kind == "step":
        from .read_document import read_document

        return read_document(opened.path, **options)
    from ..importer.read_file import read_file

    return document_of(read_file(path, folder=request["folder"], opened=opened, **options))
