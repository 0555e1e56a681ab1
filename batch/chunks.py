"""Items on their way through a cluster: cut into chunks, and what becomes of those that come back undone."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from .record import Item, Outcome

# Workers that a file may cost, and times that a chunk is sent again though no worker began it.
DEATHS = 3
RETURNS = 20
# A chunk ends at so many bytes, so that the large files of a batch, which come first, go one by one.
CHUNK_BYTES = 8 << 20


@dataclass
class Chunk:
    """deaths: of workers, while it was drawn alone. returns: times that it came back though nobody had begun
    it. begun: a worker has. reason: why it came back, where that is known. answer: how the task ended.
    future: Dask's."""

    items: list[Item]
    deaths: int = 0
    returns: int = 0
    begun: bool = False
    reason: str = ""
    finished: set[int] = field(default_factory=set)
    answer: dict[str, Any] | None = None
    future: Any = None

    def rest(self) -> list[Item]:
        return [item for index, item in enumerate(self.items) if index not in self.finished]


class Stock:
    """What is still to be sent. Items are taken from the source as they are needed.

    most: items of a chunk. at_once: items that are drawn at the same time in one task.
    """

    def __init__(self, items: Iterable[Item], most: int, at_once: int) -> None:
        self._source = iter(items)
        self._most, self._at_once = most, at_once
        self._items: deque[Item] = deque()
        self._again: deque[Chunk] = deque()

    def next(self, takers: int) -> Chunk | None:
        """The next chunk, or None when there is nothing left. takers: tasks that the cluster runs at once.

        Chunks are full ones while there is enough for all takers, and ever smaller at the end, so that none
        has much left to do when the others have nothing.
        """
        if self._again:
            return self._again.popleft()
        enough = 2 * takers * self._most
        while len(self._items) < enough and (item := next(self._source, None)) is not None:
            self._items.append(item)
        if not self._items:
            return None
        most = max(1, min(self._most, len(self._items) // (2 * takers)))
        items = [self._items.popleft()]
        size = items[0].size
        while self._items and len(items) < most and size + self._items[0].size <= CHUNK_BYTES:
            items.append(self._items.popleft())
            size += items[-1].size
        return Chunk(items)

    def give_back(self, chunk: Chunk) -> list[Outcome]:
        """Takes what is left of a chunk, to be sent again; returns what is failed instead.

        Of a chunk in whose midst a worker died, the items that were being drawn go alone from now on, until
        they are done or have cost ``DEATHS`` workers; so one bad file ends neither the batch nor others.
        """
        rest = chunk.rest()
        if not rest:
            return []
        if not chunk.begun:
            if chunk.returns < RETURNS:
                self._again.append(Chunk(rest, deaths=chunk.deaths, returns=chunk.returns + 1))
                return []
            reason = chunk.reason or f"{RETURNS} workers of the cluster died before they began with it"
            return [failed(item, reason) for item in rest]
        if len(chunk.items) > 1:
            alone, others = rest[: self._at_once], rest[self._at_once :]
            self._again.extend(Chunk([item], deaths=1) for item in alone)
            if others:
                self._again.append(Chunk(others))
            return []
        deaths = chunk.deaths + 1
        if deaths < DEATHS:
            self._again.append(Chunk(rest, deaths=deaths))
            return []
        return [failed(rest[0], f"{chunk.reason or 'the worker died'}, {deaths} times while drawing it")]


def failed(item: Item, reason: str) -> Outcome:
    return Outcome(item.path, item.target, "failed", exit_code=3, reason=reason)
