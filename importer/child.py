"""The process that reads one file, alone with OpenCascade or OpenMesh: a crash, a hang or a full memory ends
only it.

Started by process.py or forked.py as ``child.main(arguments)``; answers on a pipe (wire.py). Nothing it or
OpenCascade prints reaches the caller's stdout or stderr.
"""

import ctypes
import gc
import json
import os
import resource
import signal
import sys
import traceback
from collections.abc import Callable
from typing import Any, BinaryIO

from . import errors, heap, wire
from .forked import peak_bytes
from .formats import TRIANGLES
from .input_file import open_input
from .mesh_model import MeshModel
from .model import BrepModel
from .report import Report

_PR_SET_PDEATHSIG = 1


def main(argument: str) -> None:
    """Reads a file. argument: as in ``serve``."""
    serve(argument, _read)


def serve(argument: str, work: Callable[[dict[str, Any], BinaryIO], None]) -> None:
    """Does the work within the limits asked for, says on the pipe what went wrong, and ends the process.

    argument: JSON of process.Request, with the number of the pipe and of the parent process; of a forked
    child also with the bytes of data that it inherited, which are none of the file's.
    """
    request: dict[str, Any] = json.loads(argument)
    _die_with(request["parent"])
    _mute()
    with os.fdopen(request["pipe"], "wb") as pipe:
        try:
            if request["memory_limit"] is not None:
                limit = request["memory_limit"] + request.get("inherited", 0)
                limit_data(limit)
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            heap.use()
            gc.disable()  # little is to be found in a process of one file, and OCP's classes are many
            work(request, pipe)
        except errors.Error as error:
            message: dict[str, Any] = {
                "error": type(error).__name__,
                "message": str(error),
                "detail": error.detail,
            }
            if isinstance(error, errors.EmptyError):
                message["report"] = error.report
            wire.send(pipe, message)
        except BaseException as error:
            limit_data(None)
            wire.send(pipe, _foreign(request["name"], error, request["memory_limit"] is not None))
    os._exit(0)  # OpenCascade's static destructors have been seen to hang


def limit_data(limit: int | None) -> None:
    """Of this process: bytes, or None for no more than what the system allows. A hard limit set from outside
    stays."""
    hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
    bounds = [x for x in (limit, hard) if x is not None and x != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min(bounds, default=resource.RLIM_INFINITY), hard))


def preload() -> None:
    """Imports what reading needs, so that forked children find it (process.py, start="fork")."""
    heap.use()
    from . import occt, read_file, read_triangles  # noqa: F401

    occt.initialize()


def _read(request: dict[str, Any], pipe: BinaryIO) -> None:
    report = Report(on_stage=lambda stage: wire.send(pipe, {"stage": stage, "fraction": None}))
    path, name, folder, limit = (request[key] for key in ("path", "name", "folder", "memory_limit"))
    opened = open_input(path, name=name, folder=folder, memory_limit=limit, report=report)
    model: BrepModel | MeshModel
    if opened.kind in TRIANGLES:
        from .read_triangles import read_triangles

        model = read_triangles(opened, name=name, report=report)
    else:
        from .read_file import read_file  # imports OCP

        model = read_file(
            path,
            name=name,
            folder=folder,
            heal=request["heal"],
            precision=request["precision"],
            opened=opened,
            report=report,
        )
    peak = peak_bytes()
    if limit is not None and peak > limit:  # the caller, who looks from time to time, may have missed it
        raise errors.MemoryLimitError(f"{name}: out of memory")
    model.report["peak_memory"] = peak
    wire.send_model(pipe, model)


def _foreign(name: str, error: BaseException, limited: bool) -> dict[str, Any]:
    """An exception that is none of ours: of Python, or of OpenCascade through its bindings. limited: its
    memory was: where that is too little for OCP's classes, importing them fails in many ways."""
    kind = type(error).__name__
    importing = isinstance(error, ImportError | SystemError) and not isinstance(error, ModuleNotFoundError)
    starved = importing and (
        (limited and "OCP" not in sys.modules)
        or any(words in str(error) for words in ("map segment", "zero-fill", "allocate"))
    )
    if starved or isinstance(error, MemoryError) or "OutOfMemory" in kind or "bad_alloc" in str(error):
        return {"error": "MemoryLimitError", "message": f"{name}: out of memory", "detail": ""}
    detail = traceback.format_exc()
    reason = " ".join(str(error).split())[:200]
    return {
        "error": "InputError",
        "message": f"{name}: the reader failed: {kind}: {reason}",
        "detail": detail,
    }


def _die_with(parent: int) -> None:
    """The kernel kills this process when its parent ends, however that happens."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(1)


def _mute() -> None:
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    os.close(null)
