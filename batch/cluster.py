"""Draws a batch on a Dask cluster: items in chunks, and inside each task a supervisor of its own (node.py),
since Dask neither kills a task that hangs nor isolates a crash.

What is finished is told at once, by an event, so that a worker that dies costs only the files that it had
not finished. Dask would start such a task again, whole, and after a few times give it up; instead the task
sees that it began before (``_once``) and returns, and the rest of its chunk is sent again from here: what
was being drawn alone, one file a task, the others as a chunk (chunks.py).

What workers need is trimray and the paths: inputs and outputs lie on a file system that all share.
"""

from __future__ import annotations

import contextlib
import json
import logging
import math
import queue
import threading
import time
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

from trimray import Error, UsageError, __version__

from .chunks import Chunk, Stock
from .draw import draw_file
from .node import NodeError, Nodes, absolute, words_of
from .record import Item, Outcome, Settings

# Tasks at the scheduler, for each thread of the cluster: one that runs, the others ready to be begun.
_AHEAD = 3
# Seconds: between two looks at the cluster, and before it is told that nobody works there.
_LOOK = 2.0
_LONELY = 5.0
# Seconds that a busy cluster has to stop what runs there.
_STOP = 20.0
_TOPIC = "trimray-batch"

Tell = Callable[[str], None]


def draw_on_cluster(
    items: Iterable[Item],
    settings: Settings,
    scheduler: str,
    *,
    workers_per_task: int = 1,
    chunk: int = 32,
    draw: Callable[[Item, Settings], Outcome] = draw_file,
    connect_timeout: float = 10.0,
    tell: Tell | None = None,
) -> Iterator[Outcome]:
    """What became of each item, in order of completion; items are taken as they are needed.

    scheduler: its address, such as tcp://host:8786. workers_per_task: processes that draw, for each thread
    of a Dask worker. chunk: most items of a task. draw: what they do; a function of a module that workers can
    import. connect_timeout: seconds. tell: takes remarks, a line each.
    Closing the iterator cancels all tasks and kills what they have started. Raises UsageError (Dask is not
    installed, the scheduler cannot be reached, or the cluster has another trimray or Python) and Error (the
    scheduler was lost).
    """
    with _connected(scheduler, connect_timeout) as client:
        say = tell or (lambda line: None)
        words = words_of(settings, workers_per_task, draw)
        batch = _Batch(client, scheduler, Stock(items, chunk, workers_per_task), words, say)
        try:
            yield from batch.run()
        finally:
            batch.stop()


def check(scheduler: str, connect_timeout: float = 10.0) -> None:
    """Raises UsageError where ``draw_on_cluster`` could not begin."""
    with _connected(scheduler, connect_timeout) as client:
        _Batch(client, scheduler, Stock([], 1, 1), {}, lambda line: None).check_versions()


class _Batch:
    def __init__(self, client: Any, scheduler: str, stock: Stock, words: dict[str, Any], tell: Tell) -> None:
        self._client, self._scheduler, self._tell = client, scheduler, tell
        self._stock, self._words = stock, words
        self._name = f"trimray-{uuid.uuid4().hex[:12]}"
        self._task = _task_of("draw_chunk")
        self._inbox: queue.SimpleQueue[tuple[str, dict[str, Any]]] = queue.SimpleQueue()
        self._running: dict[str, Chunk] = {}
        self._sent = 0
        self._threads = 0
        self._next_look = 0.0
        self._lonely_since: float | None = time.monotonic()

    def run(self) -> Iterator[Outcome]:
        self.check_versions()
        self._client.subscribe_topic(_TOPIC, self._event)
        while True:
            self._look()
            self._fill()
            if not self._running:
                return
            try:
                name, message = self._inbox.get(timeout=_LOOK)
            except queue.Empty:
                continue
            if name in self._running:
                yield from self._handle(name, message)

    def stop(self) -> None:
        """Cancels what runs and kills its processes; bounded in time, whatever state the cluster is in."""

        def stop() -> None:
            with contextlib.suppress(Exception):
                self._client.unsubscribe_topic(_TOPIC)
                self._client.cancel([chunk.future for chunk in self._running.values()], force=True)
                self._client.run(_task_of("stop_batch"), self._name, on_error="ignore")

        if self._client.status != "running":
            return
        thread = threading.Thread(target=stop, daemon=True)
        thread.start()
        thread.join(timeout=_STOP)

    def check_versions(self) -> None:
        """Of what client and workers must share. That of trimray is seen by each task."""
        versions = self._ask(lambda: self._client.get_versions(check=False))
        here = versions["client"]["packages"]
        there = {f"the scheduler {self._scheduler}": versions["scheduler"]}
        there |= {f"the worker {address}": found for address, found in versions["workers"].items()}
        for place, found in there.items():
            packages = (found or {}).get("packages", {})
            other, own = packages.get("python") or here["python"], here["python"]
            if other.split(".")[:2] != own.split(".")[:2]:
                raise UsageError(f"{place} runs Python {other}, this machine {own}: they must be the same")
            if packages.get("distributed", here["distributed"]) != here["distributed"]:
                self._tell(
                    f"{place} runs distributed {packages['distributed']}, this machine "
                    f"{here['distributed']}: install the same version if the batch does not run"
                )
                return

    def _look(self) -> None:
        """How large the cluster is, now and then."""
        now = time.monotonic()
        if now < self._next_look:
            return
        if self._client.status != "running":
            raise self._lost()
        self._threads = sum(self._ask(self._client.nthreads).values())
        self._next_look = now + _LOOK
        if self._threads:
            self._lonely_since = None
        elif self._lonely_since is None:
            self._lonely_since = now
        elif now - self._lonely_since > _LONELY:
            self._tell(f"{self._scheduler} has no worker: waiting for one")
            self._lonely_since = math.inf

    def _ask(self, question: Callable[[], Any]) -> Any:
        try:
            return question()
        except (OSError, RuntimeError, TimeoutError):
            raise self._lost() from None

    def _lost(self) -> Error:
        return Error(f"the connection to the scheduler {self._scheduler} was lost")

    def _fill(self) -> None:
        """Sends chunks, as many as the cluster has use for."""
        threads = max(1, self._threads)
        while len(self._running) < _AHEAD * threads:
            chunk = self._stock.next(threads)
            if chunk is None:
                return
            self._send(chunk)

    def _send(self, chunk: Chunk) -> None:
        name = f"{self._name}-{self._sent}"
        self._sent += 1
        request = self._words | {"items": absolute(chunk.items)}
        text = json.dumps({"batch": self._name, "chunk": name, "version": __version__, "request": request})
        self._running[name] = chunk
        chunk.future = self._client.submit(self._task, text, key=name, pure=False)
        chunk.future.add_done_callback(lambda _: self._inbox.put((name, {"end": True})))

    def _event(self, event: tuple[float, Any]) -> None:
        """From any batch on this cluster; in a thread of the client."""
        message = event[1]
        if isinstance(message, dict) and message.get("batch") == self._name:
            self._inbox.put((message["chunk"], message))

    def _handle(self, name: str, message: dict[str, Any]) -> Iterator[Outcome]:
        chunk = self._running[name]
        if "end" in message:
            del self._running[name]
            yield from self._end(name, chunk)
        elif "outcome" in message:
            yield from self._finish(chunk, message["index"], json.loads(message["outcome"]))
        elif "answer" in message:
            chunk.answer = message["answer"]
        else:
            chunk.begun = True

    def _finish(self, chunk: Chunk, index: int, words: dict[str, Any]) -> Iterator[Outcome]:
        if index not in chunk.finished:
            chunk.finished.add(index)
            item = chunk.items[index]
            yield replace(Outcome(**words), path=item.path, target=item.target)

    def _end(self, name: str, chunk: Chunk) -> Iterator[Outcome]:
        """Of a task, one way or another: what it has found, and what becomes of the rest."""
        status = chunk.future.status
        if status == "finished":
            answer = chunk.answer
            if answer is None or answer["count"] > len(chunk.finished):  # some events went astray
                answer = json.loads(self._ask(chunk.future.result))
            if answer["version"] != __version__:
                raise UsageError(
                    f"the worker {answer['worker']} has trimray {answer['version']}, this machine "
                    f"{__version__}: install the same version on all"
                )
            for index, words in answer.get("outcomes", ()):
                yield from self._finish(chunk, index, words)
            if answer["twice"]:
                self._forget_mark(name)
            chunk.reason = answer["reason"]
            chunk.begun = True
        elif status == "error":
            error = chunk.future.exception()
            if isinstance(error, ImportError):
                raise UsageError(
                    f"the cluster's workers cannot use trimray ({error}): install the same version on all"
                )
            killed = type(error).__name__ == "KilledWorker"
            chunk.reason = "" if killed else f"{type(error).__name__}: {' '.join(str(error).split())}"[:300]
            chunk.begun &= killed
        else:
            raise self._lost()
        yield from self._stock.give_back(chunk)

    def _forget_mark(self, name: str) -> None:
        """That of a task whose worker died, which could not do it."""
        from distributed import Event

        self._ask(Event(name, client=self._client).clear)


# What runs on the cluster.

_batches: dict[str, Nodes] = {}
_batches_lock = threading.Lock()


def draw_chunk(text: str) -> str:
    """One task, in a thread of a Dask worker. text, and what is returned: JSON."""
    from distributed import get_worker

    task = json.loads(text)
    worker = get_worker()
    head = {"batch": task["batch"], "chunk": task["chunk"]}
    answer = {"version": __version__, "worker": worker.address, "reason": "", "twice": False}
    outcomes: list[tuple[int, dict[str, Any]]] = []
    if task["version"] == __version__:
        with _once(task["chunk"]) as first:
            answer["twice"] = not first
            if first:
                worker.log_event(_TOPIC, head)
                try:
                    with _nodes(task["batch"]).lend() as node:
                        for index, outcome in node.draw(task["request"]):
                            words = vars(outcome)
                            outcomes.append((index, words))
                            # JSON, since an event carries no path whose bytes are not UTF-8.
                            worker.log_event(_TOPIC, head | {"index": index, "outcome": json.dumps(words)})
                except NodeError as error:
                    answer["reason"] = str(error)
    worker.log_event(_TOPIC, head | {"answer": answer | {"count": len(outcomes)}})
    return json.dumps(answer | {"outcomes": outcomes})


def stop_batch(name: str) -> None:
    """Kills what a batch has started in this process, and lets it start no more."""
    _nodes(name).stop()


def _nodes(batch: str) -> Nodes:
    with _batches_lock:
        return _batches.setdefault(batch, Nodes())


@contextlib.contextmanager
def _once(name: str) -> Iterator[bool]:
    """A mark at the scheduler while a task runs; False where it is there already, since the task began on a
    worker that died."""
    from distributed import Event

    mark = Event(name)
    first = not mark.is_set()
    if first:
        mark.set()
    yield first
    if first:
        mark.clear()


def _task_of(function: str) -> Callable[..., Any]:
    """A function of this module for another process. Made in here it travels by value, so that the
    scheduler, who looks into what it passes on, need not have trimray."""

    def task(*arguments: Any) -> Any:
        import importlib

        return getattr(importlib.import_module("trimray.batch.cluster"), function)(*arguments)

    return task


# The connection.


@contextlib.contextmanager
def _connected(scheduler: str, timeout: float) -> Iterator[Any]:
    try:
        import distributed
    except ImportError:
        raise UsageError("--scheduler needs Dask: pip install 'trimray[dask]'") from None
    with _quiet():
        try:
            client = distributed.Client(scheduler, timeout=timeout, set_as_default=False, name="trimray")
        except (OSError, ValueError, TypeError, ImportError) as error:
            reason = " ".join(str(error).split())[:200]
            raise UsageError(f"cannot reach the scheduler {scheduler}: {reason}") from None
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):
                client.close(timeout=5)


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Dask's logs and warnings do not reach our stderr."""
    sources = ("distributed", "tornado", "asyncio")
    names = [name for name in logging.root.manager.loggerDict if name.split(".")[0] in sources]
    loggers = [logging.getLogger(name) for name in names]
    before = [(logger.handlers, logger.propagate) for logger in loggers]
    for logger in loggers:
        logger.handlers, logger.propagate = [logging.NullHandler()], False
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for logger, (handlers, propagate) in zip(loggers, before, strict=True):
            logger.handlers, logger.propagate = handlers, propagate
