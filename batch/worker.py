"""A worker: takes one item after another from its socket and answers with what became of each.

Both ways lines of JSON, so that nothing that a damaged process sends can be more than wrong: an item is
[path, target, size], the answer the fields of an Outcome, with "retire" where the worker ends after it.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import os
import pickle
import resource
import signal
import socket
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, BinaryIO

from .record import Item, Outcome, Settings

# What a worker says first.
READY = b"{}\n"
# Exit code of a worker that failed otherwise than by its item.
BROKEN = 113
# Bytes by which its own memory may have grown since its first files before a worker is renewed.
MAX_GROWTH = 256 << 20
# Files after which growth is counted: caches and pools of threads have their size then.
_SETTLED = 3
_PR_SET_PDEATHSIG = 1

Draw = Callable[[Item, Settings], Outcome]


@dataclass(frozen=True)
class Job:
    """max_files: after which a worker is renewed; None: never, nor for growth."""

    draw: Draw
    settings: Settings
    max_files: int | None


def preload() -> None:
    """Imports what every worker needs, in the process that forks them."""
    from trimray import image_io
    from trimray.importer import child

    from . import draw  # noqa: F401

    image_io.import_library()
    child.preload()


def main(descriptor: int, parent: int, folder: str) -> None:
    """Never returns. folder: for temporary files."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != parent:
        os._exit(BROKEN)
    # These are also sent to all processes of a job: it is the caller who decides.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _mute()
    with contextlib.suppress(OSError):  # the system takes a worker before its supervisor
        Path("/proc/self/oom_score_adj").write_text("500")
    tempfile.tempdir = os.path.join(folder, str(os.getpid()))  # the server removes it
    os.mkdir(tempfile.tempdir)
    with socket.socket(fileno=descriptor) as connection, connection.makefile("rb") as inbox:
        data = inbox.read(int.from_bytes(inbox.read(8), "little"))
        try:
            job: Job = pickle.loads(data)
        except Exception as error:
            text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            connection.sendall(json.dumps({"error": text}).encode() + b"\n")
            os._exit(BROKEN)
        connection.sendall(READY)
        _work(job, connection, inbox)
    os._exit(0)  # nothing that was inherited is to be cleaned up here


def _work(job: Job, connection: socket.socket, inbox: BinaryIO) -> None:
    first = 0
    for count, line in enumerate(inbox, 1):
        answer = _answer(job, Item(*json.loads(line)))
        if job.max_files is not None:
            first = first or (_own_bytes() if count >= _SETTLED else 0)
            answer["retire"] = count >= job.max_files or (first > 0 and _grown(first))
        connection.sendall(json.dumps(answer).encode() + b"\n")
        if answer.get("retire"):
            return


def _answer(job: Job, item: Item) -> dict[str, Any]:
    """The outcome as fields; failed where the drawing function raises or returns something else."""
    try:
        answer = asdict(job.draw(item, job.settings))
        json.dumps(answer)
    except BaseException as error:
        text = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        return asdict(Outcome(item.path, item.target, "failed", 70, f"internal error: {text}"))
    return answer


def _grown(first: int) -> bool:
    """Beyond what freeing at once can mend."""
    if _own_bytes() - first < MAX_GROWTH:
        return False
    gc.collect()
    with contextlib.suppress(AttributeError):  # glibc alone has it
        ctypes.CDLL(None).malloc_trim(0)
    return _own_bytes() - first >= MAX_GROWTH


def _own_bytes() -> int:
    """Resident bytes that belong to no file."""
    try:
        pages = Path("/proc/self/statm").read_text().split()
        return (int(pages[1]) - int(pages[2])) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, IndexError, ValueError):
        return 0


def _mute() -> None:
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
    os.close(null)
