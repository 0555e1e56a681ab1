"""The process that makes the picture of the thumbnailer; started by thumbnail.py."""

from __future__ import annotations

import ctypes
import json
import os
import resource
import signal
import time
from typing import TYPE_CHECKING

from trimray import EmptyError, Error

if TYPE_CHECKING:
    from trimray.batch.draw import Picture

    from .thumbnail import Request

_PR_SET_PDEATHSIG = 1


def draw(request: Request, pipe: int, parent: int) -> None:
    """Writes the picture, whole or not at all, and tells on the pipe what became of it: the exit code and one
    line as JSON. parent: the process that waits; the kernel ends this one with it."""
    start = time.monotonic()
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        data = encoded(request, start)
        os.write(pipe, b"w")
        from trimray.image_io import write_file

        write_file(request.target, data)
        code, text = 0, ""
    except Error as error:
        code, text = error.exit_code, str(error)
    except Exception as error:
        code = Error.exit_code
        text = f"{os.path.basename(request.source)}: internal error: {type(error).__name__}: {error}"
    os.write(pipe, json.dumps([code, " ".join(text.split())[:2000]]).encode() + b"\n")


def encoded(request: Request, start: float) -> bytes:
    """The PNG, with a transparent background, so that it fits into light and dark file managers.

    A picture with missing faces, or a coarse one, is better than none; one that shows nothing is not: a file
    manager then keeps its icon. start: on the clock of time.monotonic. Raises Error.
    """
    from trimray.batch.draw import picture_of
    from trimray.batch.record import Settings
    from trimray.image_io import encode
    from trimray.threads import use_one_thread

    use_one_thread()
    settings = Settings(
        size=(request.size, request.size),
        background="transparent",
        time_limit=request.time_limit,
        memory_limit=request.memory_limit,
    )
    picture = picture_of(request.source, settings, start=start, threads=1)
    check_seen(picture, request.source)
    return encode(picture.frame, "png")


def check_seen(picture: Picture, source: str) -> None:
    """Raises EmptyError where (nearly) nothing is to be seen."""
    if picture.visible.blank:
        raise EmptyError(f"{os.path.basename(source)}: {picture.visible.reason}")
