"""The local pool in a process of its own, for tasks of a cluster: it draws chunks of items that it is sent.

Dask starts its workers as daemonic processes, which may have no children through multiprocessing, and
neither kills a task that hangs nor survives a crash in one. So a task hands its chunk to a process of its
own (``Node``), which runs the pool. It serves many chunks, one after another, so that OpenCascade is
imported once; and it dies, workers and all, as soon as its caller does. JSON lines go both ways:

    to it    {"settings": {...}, "workers": 1, "draw": [module, name],
             "items": [[path, target, size], ...]}
    from it  {"index": 3, "outcome": {...}} for each item, then {"done": true} or {"error": "reason"}
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any, BinaryIO

from .record import Item, Outcome, Settings

# Seconds without work after which a node ends; so none is left over when the batch itself was killed.
_IDLE = 60.0


class NodeError(Exception):
    """The node ended, or its pool failed; one line says how."""


class Node:
    """The caller's end. One thread at a time."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # a process group, to be killed as one
        )

    def draw(self, request: dict[str, Any]) -> Iterator[tuple[int, Outcome]]:
        """Index and outcome of each item, in order of completion. Raises NodeError."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(request).encode() + b"\n")
            self._process.stdin.flush()
            for line in self._process.stdout:
                message = json.loads(line)
                if "outcome" in message:
                    yield message["index"], Outcome(**message["outcome"])
                elif "error" in message:
                    raise NodeError(f"the local supervisor failed: {message['error']}")
                else:
                    return
        except (OSError, ValueError) as error:
            raise NodeError(f"the local supervisor is gone: {error}") from None
        raise NodeError(f"the local supervisor ended early (exit {self._process.wait()})")

    def alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        """At once, with all that it has started. May be called from any thread."""
        with contextlib.suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        self._process.wait()


class Nodes:
    """The nodes of one batch in this process: idle ones are used again."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[Node] = []
        self._busy: set[Node] = set()
        self._stopped = False

    @contextlib.contextmanager
    def lend(self) -> Iterator[Node]:
        """A node for the while of the block; one that fails there is not used again. Raises NodeError."""
        with self._lock:
            if self._stopped:
                raise NodeError("the batch was stopped")
            idle = [node for node in self._idle if node.alive()]
            node = idle.pop() if idle else Node()
            self._idle = idle
            self._busy.add(node)
        try:
            yield node
        except BaseException:
            node.kill()
            raise
        else:
            with self._lock:
                if not self._stopped:
                    self._idle.append(node)
        finally:
            with self._lock:
                self._busy.discard(node)

    def stop(self) -> None:
        """Kills all, and starts no more."""
        with self._lock:
            self._stopped = True
            nodes = [*self._idle, *self._busy]
            self._idle.clear()
        for node in nodes:
            node.kill()


def words_of(settings: Settings, workers: int, draw: Callable[[Item, Settings], Outcome]) -> dict[str, Any]:
    """What requests of a batch have in common."""
    return {"settings": asdict(settings), "workers": workers, "draw": [draw.__module__, draw.__qualname__]}


def absolute(items: list[Item]) -> list[tuple[str, str, int]]:
    """Items of a request. Paths become absolute, since a node may stand in another folder."""
    return [(os.path.abspath(item.path), os.path.abspath(item.target), item.size) for item in items]


def main() -> None:
    requests: queue.Queue[bytes] = queue.Queue()
    answers = os.fdopen(os.dup(1), "wb")
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    threading.Thread(target=_listen, args=(sys.stdin.buffer, requests), daemon=True).start()
    while True:
        try:
            request = json.loads(requests.get(timeout=_IDLE))
        except queue.Empty:
            _end()
        try:
            for index, outcome in _drawn(request):
                _send(answers, {"index": index, "outcome": asdict(outcome)})
            _send(answers, {"done": True})
        except Exception as error:
            _send(answers, {"error": f"{type(error).__name__}: {error}"[:500]})


def _listen(stream: BinaryIO, requests: queue.Queue[bytes]) -> None:
    """Hands requests on; the end of them is the end of the caller, and of this process."""
    for line in stream:
        requests.put(line)
    _end()


def _end() -> None:
    """Ends this process and all workers of its pool."""
    os.killpg(0, signal.SIGKILL)


def _drawn(request: dict[str, Any]) -> Iterator[tuple[int, Outcome]]:
    from .pool import draw_all

    words = request["settings"]
    settings = Settings(**{**words, "size": tuple(words["size"])})
    draw = getattr(importlib.import_module(request["draw"][0]), request["draw"][1])
    items = [Item(*words) for words in request["items"]]
    index = {item.target: i for i, item in enumerate(items)}
    for outcome in draw_all(items, settings, request["workers"], draw=draw):
        yield index[outcome.target], outcome


def _send(stream: BinaryIO, message: dict[str, Any]) -> None:
    stream.write(json.dumps(message).encode() + b"\n")
    stream.flush()


if __name__ == "__main__":
    main()
