"""The caller's side of the child process: start it, watch it, turn its end into a model or an Error."""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from . import errors, wire
from .forked import Forked, fork_child
from .mesh_model import MeshModel
from .model import BrepModel
from .step_text import StepText

Progress = Callable[[str, float | None], None]
# How the child begins: as a new interpreter, or as a copy of this process.
Start = Literal["spawn", "fork"]

# Seconds between two looks at the child's memory.
_WATCH_INTERVAL = 0.05
_PAGE = os.sysconf("SC_PAGE_SIZE")
# Exit codes with which Python and the dynamic loader end a process that cannot load its libraries, such as
# for want of memory.
_UNLOADABLE = (1, 127)

# The child runs the importer alone: a bare stand-in for the package around it keeps the child from loading
# what only the caller needs (the native core, the image library).
_BOOTSTRAP = """
import sys, types
package, _, _ = sys.argv[1].rpartition(".")
root = types.ModuleType(package)
root.__path__ = [sys.argv[2]]
sys.modules[package] = root
import importlib
importlib.import_module(sys.argv[3]).main(sys.argv[4])
"""


@dataclass(frozen=True)
class Request:
    """What the child is asked to read. folder: a scratch folder that the caller removes."""

    verb: ClassVar[str] = "read"  # what messages say is not done

    path: str
    name: str
    folder: str
    heal: str
    precision: float | None
    memory_limit: int | None  # bytes


def run_child(
    request: Request,
    *,
    time_limit: float | None,
    progress: Progress | None = None,
    module: str = f"{__package__}.child",
    start: Start = "spawn",
) -> BrepModel | MeshModel:
    """Reads in a child process.

    Raises TimeLimitError, MemoryLimitError, InputError (also for a crash), EmptyError; an exception of
    ``progress`` and KeyboardInterrupt pass through. The child is dead when this returns or raises.
    module: the child's code, ``module.main(argument)``; tests put a misbehaving one in its place.
    start: "fork" spares the child a second of imports where this process has made them (forked.py).
    """
    header, blobs = _ask(request, time_limit, progress, module, start)
    try:
        return wire.model_of(header["model"], blobs)
    except (ValueError, KeyError, TypeError) as error:
        raise errors.InputError(f"{request.name}: the reading process answered nonsense: {error}") from None


def ask_child(
    request: Request,
    *,
    module: str,
    time_limit: float | None,
    progress: Progress | None = None,
    start: Start = "spawn",
) -> dict[str, Any]:
    """As run_child, for a child whose answer is not a model: what it sent as {"answer": {...}}."""
    header, _ = _ask(request, time_limit, progress, module, start)
    answer: dict[str, Any] = header["answer"]
    return answer


def _ask(
    request: Request, time_limit: float | None, progress: Progress | None, module: str, start: Start
) -> tuple[dict[str, Any], list[bytes]]:
    """The last message of a child, and its raw blocks."""
    receive, send = os.pipe()
    argument = json.dumps({**asdict(request), "pipe": send, "parent": os.getpid()})
    try:
        child = _spawn(module, argument, send) if start == "spawn" else fork_child(module, argument, send)
    except OSError as error:
        os.close(receive)
        raise errors.Error(f"{request.name}: cannot start the reading process: {error}") from None
    finally:
        os.close(send)
    watch = _Watch(child, receive, request, time_limit)
    try:
        return watch.wait(progress)
    except errors.Error as error:
        error.peak_memory = watch.peak_memory
        raise
    finally:
        os.close(receive)
        child.kill()
        child.wait()


def _spawn(module: str, argument: str, pipe: int) -> subprocess.Popen[bytes]:
    package_folder = str(Path(__file__).absolute().parent.parent)
    return subprocess.Popen(
        [sys.executable, "-c", _BOOTSTRAP, str(__package__), package_folder, module, argument],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        pass_fds=(pipe,),
        start_new_session=True,  # Ctrl-C reaches the caller, who kills the child
    )


class _Watch:
    def __init__(
        self, child: subprocess.Popen[bytes] | Forked, pipe: int, request: Request, limit: float | None
    ) -> None:
        self.child, self.pipe, self.request = child, pipe, request
        self.time_limit = limit
        self.start = time.monotonic()
        self.peak_memory = 0
        self.stage = "start"

    def wait(self, progress: Progress | None) -> tuple[dict[str, Any], list[bytes]]:
        """Until the answer is there, or the reason why not."""
        inbox = wire.Inbox()
        while True:
            if select.select([self.pipe], [], [], self._patience())[0]:
                data = os.read(self.pipe, 1 << 20)
                if not data:
                    raise self._ended()
                for message, blobs in inbox.feed(data):
                    if "stage" in message:
                        self.stage = message["stage"]
                        if progress is not None:
                            progress(self.stage, message["fraction"])
                    elif "error" in message:
                        raise self._error(message)
                    else:
                        return message, blobs
            self._check_limits()

    def _patience(self) -> float | None:
        if self.request.memory_limit is not None:
            return _WATCH_INTERVAL
        if self.time_limit is not None:
            return max(0.0, self.start + self.time_limit - time.monotonic())
        return None

    def _check_limits(self) -> None:
        limit = self.request.memory_limit
        if limit is not None:
            with contextlib.suppress(OSError, IndexError, ValueError):
                pages = int(Path(f"/proc/{self.child.pid}/statm").read_text().split()[1])
                self.peak_memory = max(self.peak_memory, pages * _PAGE)
            if self.peak_memory > limit:
                raise self._memory_error()
        if self.time_limit is not None and time.monotonic() - self.start >= self.time_limit:
            raise errors.TimeLimitError(
                f"{self.request.name}: not {self.request.verb} within {self.time_limit:g} s "
                f"(stopped in stage '{self.stage}')"
            )

    def _memory_error(self) -> errors.MemoryLimitError:
        limit = self.request.memory_limit
        bound = f"within {limit / 2**20:.0f} MiB" if limit is not None else "in this machine's memory"
        return errors.MemoryLimitError(
            f"{self.request.name}: cannot be {self.request.verb} {bound} (stage '{self.stage}')"
        )

    def _error(self, message: dict[str, Any]) -> errors.Error:
        kind = getattr(errors, message["error"], errors.InputError)
        if kind is errors.MemoryLimitError and message["message"].endswith("out of memory"):
            return self._memory_error()
        if kind is errors.EmptyError:
            return errors.EmptyError(message["message"], detail=message["detail"], report=message["report"])
        error: errors.Error = kind(message["message"], detail=message["detail"])
        return error

    def _ended(self) -> errors.Error:
        """The child closed its end without an answer."""
        try:
            code = self.child.wait(timeout=5)
        except subprocess.TimeoutExpired:
            code = 0
        if isinstance(self.child, Forked):
            self.peak_memory = max(self.peak_memory, self.child.peak_memory)
        limit = self.request.memory_limit
        near_limit = limit is not None and self.peak_memory > 0.7 * limit
        unloadable = limit is not None and code in _UNLOADABLE
        if code == -signal.SIGKILL or (code < 0 and near_limit) or unloadable:
            return self._memory_error()
        name = self.request.name
        if code == -signal.SIGALRM:
            return errors.InputError(f"{name}: {self._not_a_number()}: OpenCascade does not end on it")
        if code < 0:
            how = f"{signal.Signals(-code).name} in stage '{self.stage}'"
            return errors.InputError(f"{name}: {self._reader()} crashed on it ({how})")
        return errors.InputError(
            f"{name}: the reading process ended early (exit {code}, stage '{self.stage}')"
        )

    def _reader(self) -> str:
        return "the reader of triangles" if self.stage == "triangles" else "OpenCascade"

    def _not_a_number(self) -> str:
        """Which record made the child set its alarm (read_step.py)."""
        try:
            record = StepText(Path(self.request.path).read_bytes()).not_a_number()
        except OSError:
            record = None
        where = f"#{record.id} ({record.kind})" if record else "a record"
        return f"{where} holds a coordinate that is not a number"
