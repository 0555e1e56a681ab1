"""write: a model to a STEP, IGES or BREP file, by OpenCascade's writers, in a child process."""

from __future__ import annotations

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ..importer import errors, shapes
from ..importer.process import Progress, Request, Start, ask_child
from ..importer.reader import input_file

if TYPE_CHECKING:
    from .. import _core

Via = Literal["step", "iges", "brep"]
Schema = Literal["ap203", "ap214", "ap242"]
VIAS = ("step", "iges", "brep")
SCHEMAS = ("ap203", "ap214", "ap242")
_SUFFIX = {"step": ".step", "iges": ".igs", "brep": ".brep"}


@dataclass(frozen=True)
class WriteRequest(Request):
    """source: what ``path`` is: a "file" to be read, a saved "store", or a saved "model" of the importer."""

    verb: ClassVar[str] = "written"

    source: str = "file"
    via: str = "step"
    schema: str = "ap242"
    target: str = ""
    properties: bool = False


@dataclass(frozen=True)
class Written:
    """What was written. data: the bytes, where no path was given for them.

    issues: (face number or -1, reason) of what the file does not hold.
    """

    path: Path | None
    data: bytes | None
    size: int  # bytes
    issues: tuple[tuple[int, str], ...]
    seconds: dict[str, float]  # by stage


def write(
    source: str | os.PathLike[str] | bytes | _core.Store | Any,
    target: str | os.PathLike[str] | None = None,
    *,
    via: Via = "step",
    schema: Schema = "ap242",
    properties: bool = False,
    name: str | None = None,
    heal: str = "default",
    precision: float | None = None,
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Progress | None = None,
    start: Start = "spawn",
) -> Written:
    """Writes a model in another process and answers what became of it.

    source: a path or the bytes of a STEP, IGES or BREP file, read as the importer reads it; a cadquery,
        build123d or OCP shape; or a Store, whose B-rep is made anew from its arrays alone.
    target: where the file goes; None: its bytes are in the answer.
    via: the format. schema: of STEP alone. name: what messages call the source.
    properties: let STEP files say the volume, area and centroid of parts made of solids, as
        ``inspect`` measures them.
    heal, precision, time_limit (s), memory_limit (bytes), progress, start: as in importer.read_model.
    Raises UsageError, InputError, EmptyError, OutputError, TimeLimitError, MemoryLimitError.
    """
    if via not in VIAS:
        raise errors.UsageError(f"via: '{via}' is not one of {', '.join(VIAS)}")
    if schema not in SCHEMAS:
        raise errors.UsageError(f"schema: '{schema}' is not one of {', '.join(SCHEMAS)}")
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        kind, path, shown = _saved(source, name, Path(folder))
        output = Path(folder) / f"output{_SUFFIX[via]}"
        request = WriteRequest(
            str(path),
            shown,
            folder,
            heal,
            precision,
            memory_limit,
            kind,
            via,
            schema,
            str(output),
            properties,
        )
        answer = ask_child(
            request, module=f"{__package__}.child", time_limit=time_limit, progress=progress, start=start
        )
        data = output.read_bytes() if target is None else None
        if target is not None:
            _move(output, Path(os.fspath(target)))
    return Written(
        path=None if target is None else Path(os.fspath(target)),
        data=data,
        size=int(answer["bytes"]),
        issues=tuple((int(face), str(reason)) for face, reason in answer["issues"]),
        seconds=answer["seconds"],
    )


def _saved(source: Any, name: str | None, folder: Path) -> tuple[str, Path, str]:
    """The source as a file that the child can open: its kind, where it is, and what it is called."""
    if hasattr(source, "arrays") and hasattr(source, "save"):
        path = folder / "input.store"
        path.write_bytes(source.save())
        return "store", path, name or "<store>"
    if not isinstance(source, str | os.PathLike | bytes | bytearray | memoryview) and shapes.is_shape(source):
        from .from_model import save_model  # this process has OpenCascade: the shape is its

        path = folder / "input.model"
        save_model(shapes.from_shape(source, name=name), path)
        return "model", path, name or type(source).__name__
    path, shown = input_file(source, name, folder)
    return "file", path, shown


def _move(output: Path, target: Path) -> None:
    """All of the file at once, or none."""
    beside = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        shutil.copyfile(output, beside)
        os.replace(beside, target)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise errors.OutputError(f"{target}: {error.strerror or error}") from None
