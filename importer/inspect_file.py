"""inspect: a file or a shape in, an Inspection out."""

import tempfile
from pathlib import Path
from typing import Any

from . import errors, shapes
from .inspection import Inspection
from .inspection_wire import inspection_of
from .process import Progress, Request, Start, ask_child
from .reader import Heal, check_arguments, input_file


def inspect(
    source: Any,
    *,
    name: str | None = None,
    heal: Heal = "default",
    precision: float | None = None,
    time_limit: float | None = None,
    memory_limit: int | None = None,
    progress: Progress | None = None,
    start: Start = "spawn",
) -> Inspection:
    """What a file declares, what arrived of it, and how good it is by OpenCascade's own measure.

    source: a path or the bytes of a STEP, IGES or BREP file, read as ``load`` reads it in a process of its
        own; or a cadquery, build123d or OCP shape, which is inspected in this process.
    All arguments and errors as in ``read_model``; UsageError also for files of triangles.
    progress: called with "parse", "transfer", "measure", "edges", "check" and others, and None.
    """
    check_arguments(heal, precision, time_limit, memory_limit)
    if not isinstance(source, str | bytes | bytearray | memoryview) and shapes.is_shape(source):
        return _inspect_shape(source, name)
    with tempfile.TemporaryDirectory(prefix="trimray-") as folder:
        path, shown = input_file(source, name, Path(folder))
        request = Request(str(path), shown, folder, heal, precision, memory_limit)
        answer = ask_child(
            request,
            module=f"{__package__}.inspect_child",
            time_limit=time_limit,
            progress=progress,
            start=start,
        )
    try:
        return inspection_of(answer)
    except (ValueError, KeyError, TypeError) as error:
        raise errors.InputError(f"{shown}: the reading process answered nonsense: {error}") from None


def _inspect_shape(source: Any, name: str | None) -> Inspection:
    from .inspect_scene import inspect_scene
    from .read_file import ReadScene
    from .report import Report

    report = Report(format="shape")
    scene, shown = shapes.scene_of(source, name, report)
    return inspect_scene(ReadScene(scene, "mm", 1.0, {"name": shown}), report, name=shown)
