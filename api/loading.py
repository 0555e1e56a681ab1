"""load: a file or a shape to a Model, by the importer or from the cache."""

from __future__ import annotations

import base64
import math
import os
import time
from typing import TYPE_CHECKING, Any, Literal

from . import _core, cache
from .hierarchy import Hierarchy
from .importer.errors import InputError

if TYPE_CHECKING:
    from .importer import BrepModel, MeshModel
    from .model import Model, Progress

Heal = Literal["default", "off", "strict"]
Start = Literal["spawn", "fork"]


def load(
    path_or_shape: Any,
    *,
    cache: bool = True,
    heal: Heal = "default",
    precision: float | None = None,
    time_limit: float | None = None,
    memory_limit: int | None = None,
    name: str | None = None,
    progress: Progress | None = None,
    prepare: bool = False,
    start: Start = "spawn",
) -> Model:
    """Reads a model: STEP, IGES, BREP, STL, OBJ, PLY or OFF, also compressed, or a shape given in Python.

    Files of triangles have no unit: theirs is taken as mm. Each of their groups is one face of kind "mesh".

    path_or_shape: a path; bytes (``name`` then stands for the path); a cadquery Workplane, Shape or
        Assembly; an OCP shape.
    cache: keep the imported surfaces under $XDG_CACHE_HOME/trimray and use them again; never for shapes
        given in Python.
    heal: "default" is what OpenCascade's readers do, "off" leaves the file's geometry alone, "strict"
        reports every repair.
    precision: mm, below it points are taken as equal and IGES faces are sewn; by default the file's own.
    time_limit: seconds, memory_limit: bytes, of the child process that reads the file; none by default.
    progress: called with a stage and a fraction or None.
    prepare: begin to make the model ready for rays at once, in the background, rather than at the first ray.
    start: of the reading process: "spawn" is a new interpreter; "fork" a copy of this one, for programs that
        read many files: it takes no second to start once ``trimray.importer.child.preload()`` was called. No
        other thread may be at work meanwhile.

    A face that cannot be drawn is no error: see ``Model.report``. Raises InputError for what cannot be read,
    EmptyError where there is no face, TimeLimitError, MemoryLimitError, UsageError.
    """
    options = {"heal": heal, "precision": precision}
    limits = {"time_limit": time_limit, "memory_limit": memory_limit, "start": start}
    path = path_or_shape
    if not isinstance(path, str | os.PathLike | bytes):
        return _import(path, None, name, options, limits, progress, prepare)
    shown = name or (os.fsdecode(path) if not isinstance(path, bytes) else "<bytes>")
    if not cache and (isinstance(path, bytes) or os.fspath(path)):  # the reader looks at the file itself
        return _import(path, None, name, options, limits, progress, prepare)
    data = path if isinstance(path, bytes) else _read(path, shown)
    if _refers_to_files(data):
        return _import(path, None, name, options, limits, progress, prepare)
    key = _cache.key(data, os.path.splitext(shown)[1], options)
    return _from_cache(key, shown, prepare) or _import(path, key, name, options, limits, progress, prepare)


_cache = cache  # load's argument bears the module's name


def _read(path: str | os.PathLike[str], shown: str) -> bytes:
    """A file's bytes; whatever is no readable regular file is an InputError. shown: the name in messages."""
    if not os.fspath(path):
        raise InputError("the path of the input is empty")
    try:
        if os.path.isdir(path):
            raise InputError(f"{shown}: is a directory")
        if os.path.exists(path) and not os.path.isfile(path):
            raise InputError(f"{shown}: not a regular file")
        with open(path, "rb") as file:
            data = file.read()
    except (OSError, ValueError) as error:
        raise InputError(f"{shown}: {getattr(error, 'strerror', None) or error}") from None
    if not data:
        raise InputError(f"{shown}: empty")
    return data


def _refers_to_files(data: bytes) -> bool:
    """Does a STEP file refer to other model files, or an OBJ file to its materials? What it shows then
    depends on more than its own bytes."""
    if b"DOCUMENT_FILE" not in data:
        return data.startswith(b"mtllib ") or b"\nmtllib " in data
    from .importer.step_text import StepText

    return bool(StepText(data).external_files)


def _from_cache(key: str, shown: str, prepare: bool) -> Model | None:
    start = time.perf_counter()
    entry = cache.read(key)
    if entry is None:
        return None
    try:
        hierarchy = Hierarchy(_core.Store.load(entry.store))
        if prepare:
            hierarchy.begin()
        import numpy as np  # while the hierarchy is made

        bounds = np.array(entry.facts["bounds"], np.float64).reshape(2, 3)
        outline = np.frombuffer(base64.b64decode(entry.facts["outline"]), "<f8").reshape(-1, 3)
    except (_core.CoreError, KeyError, TypeError, ValueError):
        return None
    seconds = {**entry.facts.get("seconds", {}), "cache": time.perf_counter() - start}
    from .model import Model

    return Model(hierarchy, seconds=seconds, extent=(bounds, outline), cached=True, source=shown)


def _store(read: BrepModel | MeshModel) -> _core.Store:
    from .importer import MeshModel
    from .importer.build_store import build_store

    if isinstance(read, MeshModel):
        return _core.Store.from_triangles(
            read.vertices, read.triangles, read.group_ends, read.group_colors, read.meta_json()
        )
    return build_store(read)


def _import(
    source: Any,
    key: str | None,
    name: str | None,
    options: dict[str, Any],
    limits: dict[str, Any],
    progress: Progress | None,
    prepare: bool,
) -> Model:
    from .importer import read_model
    from .model import Model

    shown = name or (os.fsdecode(source) if isinstance(source, str | os.PathLike) else "")
    read = read_model(source, name=name, progress=progress, **options, **limits)
    seconds: dict[str, float] = {}
    start = time.perf_counter()
    if progress is not None:
        progress("store", None)
    try:
        store = _store(read)
    except _core.CoreError as error:
        raise InputError(f"{shown or 'the model'}: {error}") from None
    seconds["store"] = time.perf_counter() - start
    hierarchy = Hierarchy(store)
    if prepare:
        hierarchy.begin()
    model = Model(hierarchy, seconds=seconds, source=shown)
    if key is not None:
        start = time.perf_counter()
        bounds, outline = model._extent
        seconds["extent"] = time.perf_counter() - start
        facts = {
            "bounds": bounds.ravel().tolist(),
            "outline": base64.b64encode(outline.astype("<f8").tobytes()).decode(),
            "seconds": seconds,
        }
        if bool((abs(bounds) < math.inf).all()):
            cache.write(key, cache.Entry(facts, store.save()))
    return model
