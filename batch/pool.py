"""Draws many files in worker processes. A crash, a hang or hunger costs the file that caused it alone.

Every worker has one file at a time and a socket of its own, so that it is always known which file a dead
worker had, and no lock is shared that it could leave locked (docs/decisions/0007-batch-pool.md).
"""

from __future__ import annotations

import contextlib
import json
import signal
import socket
import time
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import wait
from typing import Any

from trimray import Error

from . import fork_server
from .draw import draw_file, hash_file
from .leftovers import remove_leftover_of
from .record import STATUSES, Item, Outcome, Settings
from .worker import BROKEN, READY, Draw, Job

# Files that a worker draws before it is renewed; renewing takes milliseconds.
MAX_FILES = 200
# A worker keeps to the time limit by itself; it is killed when it is so much over it.
GRACE_SHARE, GRACE_SECONDS = 1.1, 3.0
# A file during which the system killed its worker, or that of a lost server, is tried so often.
_MAX_TRIES = 3
# So many vain attempts in a row to have a worker are no accident.
_MAX_STILLBORN = 5
_RETRY_SECONDS = 1.0
# Bytes without an end of line that a sane worker never sends.
_MAX_LINE = 1 << 20


def draw_all(
    items: Iterable[Item],
    settings: Settings,
    workers: int,
    *,
    draw: Draw = draw_file,
    max_files: int | None = MAX_FILES,
) -> Iterator[Outcome]:
    """The outcome of every item, in order of completion; items are taken as workers fall free.

    workers: processes, 1 or more. draw: what they do; can be pickled by its name. max_files: after which a
    worker is renewed, as it is when its memory grows; None: never. Closing the iterator kills all workers at
    once. They also die with this process, however it ends. Raises Error where no worker can be started.
    """
    pool = _Pool(items, Job(draw, settings, max_files), max(1, workers))
    done = False
    try:
        yield from pool.run()
        done = True
    finally:
        pool.close(clean=done)


@dataclass
class _Worker:
    connection: socket.socket
    pid: int = 0  # not told yet
    item: Item | None = None
    tries: int = 0  # of the item
    start: float = 0.0  # on the clock of time.monotonic
    deadline: float | None = None
    verdict: tuple[int, str] | None = None  # exit code and reason, where it is being killed
    ended: bool = False  # it has closed its end
    ready: bool = False
    free: bool = False
    answers: int = 0
    inbox: bytes = b""


class _Pool:
    def __init__(self, items: Iterable[Item], job: Job, size: int) -> None:
        self.items, self.job, self.size = iter(items), job, size
        self.again: deque[tuple[Item, int]] = deque()  # to be tried once more, each by a new worker
        self.server: fork_server.ForkServer | None = None
        self.workers: dict[int, _Worker] = {}  # by number of request
        self.stillborn = 0
        self.complaint = "no reason was given"  # of a worker that could not start
        self.not_before = 0.0  # when a worker may be asked for
        self.outcomes: deque[Outcome] = deque()

    def run(self) -> Iterator[Outcome]:
        while True:
            # What is done is kept by the caller before anyone gets more to do: an end of this process at any
            # moment costs each worker one file.
            if not self.outcomes:
                self._staff()
            if self.outcomes:
                yield self.outcomes.popleft()
            elif self.workers:
                self._wait()
            elif self.again:
                time.sleep(_RETRY_SECONDS)
            else:
                return

    def close(self, *, clean: bool) -> None:
        """clean: every worker has ended."""
        server, self.server = self.server, None
        for worker in self.workers.values():
            worker.connection.close()
        if server is not None:
            if clean and not self.workers:
                fork_server.give_back(server)
            else:
                server.close()

    def _staff(self) -> None:
        """Gives workers that are free the next item, and asks for more workers while there are items."""
        for worker in self.workers.values():
            if worker.free:
                following = None if self.again else self._next()
                if following is not None:
                    self._give(worker, following)
                else:  # it ends, and a new one takes what is left
                    self._dismiss(worker)
        while len(self.workers) < self.size and time.monotonic() >= self.not_before:
            following = self.again.popleft() if self.again else self._next()
            if following is None:
                return
            try:
                self.server = self.server or fork_server.take()
                request, connection = self.server.fork(self.job)
            except OSError:
                self.again.append(following)
                self._server_lost()
                continue
            self.workers[request] = worker = _Worker(connection)
            self._give(worker, following)

    def _next(self) -> tuple[Item, int] | None:
        return next(((item, 0) for item in self.items), None)

    def _give(self, worker: _Worker, following: tuple[Item, int]) -> None:
        item, tries = following
        worker.item, worker.tries, worker.free = item, tries + 1, False
        worker.start = time.monotonic()
        limit = self.job.settings.time_limit
        if limit is not None:
            worker.deadline = worker.start + GRACE_SHARE * limit + GRACE_SECONDS
        with contextlib.suppress(OSError):  # it is dead, as the server will tell
            worker.connection.sendall(json.dumps([item.path, item.target, item.size]).encode() + b"\n")

    def _wait(self) -> None:
        """Until something has happened, or a deadline is over."""
        assert self.server is not None
        now = time.monotonic()
        deadlines = [w.deadline for w in self.workers.values() if w.deadline is not None]
        if self.not_before > now:
            deadlines.append(self.not_before)
        timeout = max(0.0, min(deadlines) - now) if deadlines else None
        open_ones = {w.connection: w for w in self.workers.values() if not w.ended}
        readable = wait([self.server.socket, *open_ones], timeout)
        for connection, worker in open_ones.items():
            if connection in readable:
                self._hear(worker)
        if self.server.socket in readable:
            self._obey(self.server.receive())
        now = time.monotonic()
        for worker in self.workers.values():
            if worker.deadline is not None and now >= worker.deadline and worker.pid and self.server:
                worker.deadline = None
                if worker.item is not None:
                    worker.verdict = (5, f"not drawn within {self.job.settings.time_limit:g} s, and stopped")
                self.server.kill(worker.pid)

    def _hear(self, worker: _Worker) -> None:
        """Takes what a worker has sent."""
        try:
            data = worker.connection.recv(1 << 16, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        worker.ended = not data
        *lines, worker.inbox = (worker.inbox + data).split(b"\n")
        if len(worker.inbox) > _MAX_LINE:
            lines, worker.inbox = [*lines, worker.inbox], b""
        for line in lines:
            if worker.ready:
                self._take(worker, line)
            elif line + b"\n" == READY:
                worker.ready = True
            else:
                self.complaint = _complaint(line)

    def _take(self, worker: _Worker, line: bytes) -> None:
        """A worker's answer."""
        item, worker.item = worker.item, None
        if item is None:  # it has been answered: what comes now is noise, and its end is near
            return
        outcome, retire = _outcome(item, line)
        self.outcomes.append(outcome)
        worker.answers += 1
        self.stillborn = 0
        if retire:
            self._dismiss(worker)
        else:
            worker.free = True

    def _dismiss(self, worker: _Worker) -> None:
        worker.free = False
        with contextlib.suppress(OSError):
            worker.connection.shutdown(socket.SHUT_WR)
        worker.deadline = time.monotonic() + GRACE_SECONDS

    def _obey(self, message: dict[str, Any] | None) -> None:
        """What the server says."""
        if message is None:
            self._server_lost()
        elif "forked" in message:
            self.workers[message["request"]].pid = message["forked"]
        elif "refused" in message:
            worker = self.workers.pop(message["request"])
            worker.connection.close()
            if worker.item is not None:
                self.again.append((worker.item, worker.tries - 1))
            self._stillborn(f"no worker could be started: {message['refused']}")
        elif "ended" in message:
            for request, worker in list(self.workers.items()):
                if worker.pid == message["ended"]:
                    self._hear(worker)
                    del self.workers[request]
                    worker.connection.close()
                    self._bury(worker, int(message["code"]))

    def _bury(self, worker: _Worker, code: int) -> None:
        """Decides what becomes of the item of a worker that has ended."""
        item = worker.item
        if item is None:
            return
        remove_leftover_of(item.target)
        if worker.verdict is not None:
            self._fail(worker, *worker.verdict)
        elif not worker.ready and code == BROKEN:
            self.again.append((item, worker.tries - 1))
            self._stillborn(f"workers do not start: {self.complaint}")
        elif worker.answers and worker.tries < _MAX_TRIES:
            # An earlier file may be to blame: this one is tried again by itself.
            self.again.append((item, worker.tries))
        elif code == -signal.SIGKILL:
            if worker.tries < _MAX_TRIES:
                self.again.append((item, worker.tries))
            else:
                self._fail(worker, 5, "its process was killed, as the system does where memory runs out")
        elif code < 0:
            self._fail(worker, Error.exit_code, f"drawing it crashed ({signal.Signals(-code).name})")
        else:
            self._fail(worker, Error.exit_code, f"its process ended early (exit {code})")

    def _fail(self, worker: _Worker, exit_code: int, reason: str) -> None:
        """Ends its item. The hash, which died with the worker, tells a later run that it is the same file."""
        item = worker.item
        assert item is not None
        try:
            sha256 = hash_file(item.path)
        except Error:
            sha256 = ""
        seconds = round(time.monotonic() - worker.start, 3)
        self.outcomes.append(
            Outcome(item.path, item.target, "failed", exit_code, reason, sha256=sha256, seconds=seconds)
        )

    def _server_lost(self) -> None:
        """It has ended, and all workers with it: what they had is done again by others."""
        if self.server is not None:
            self.server.close()
        self.server = None
        for worker in self.workers.values():
            self._hear(worker)
            worker.connection.close()
            if worker.item is not None:
                remove_leftover_of(worker.item.target)
                if worker.tries < _MAX_TRIES:
                    self.again.append((worker.item, worker.tries))
                else:
                    self._fail(worker, Error.exit_code, "the server of workers ended while it was drawn")
        self.workers.clear()
        self._stillborn("the server of workers ends")

    def _stillborn(self, reason: str) -> None:
        self.stillborn += 1
        self.not_before = time.monotonic() + _RETRY_SECONDS
        if self.stillborn >= _MAX_STILLBORN and not self.workers:
            raise Error(reason)


def _complaint(line: bytes) -> str:
    try:
        return str(json.loads(line)["error"])
    except (ValueError, TypeError, KeyError):
        return "no reason can be read"


def _outcome(item: Item, line: bytes) -> tuple[Outcome, bool]:
    """What a worker's line says of its item, and whether it ends now; a failure where that is nonsense."""
    try:
        answer = json.loads(line)
        retire = bool(answer.pop("retire", False))
        answer |= {"path": item.path, "target": item.target}
        outcome = Outcome(**answer)
        if outcome.status in STATUSES:
            return outcome, retire
    except (ValueError, TypeError, AttributeError):
        pass
    return Outcome(item.path, item.target, "failed", Error.exit_code, "its process answered nonsense"), True
