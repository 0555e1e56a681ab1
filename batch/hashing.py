"""SHA-256 of many files by a few threads, beside whatever else goes on."""

from __future__ import annotations

import hashlib
import os
import queue
import stat
import threading
import time
from collections.abc import Iterator, Sequence

_CHUNK = 1 << 20
_LOOK_SECONDS = 0.2


def sha256_of(path: str, stop: threading.Event | None = None) -> str:
    """Hex; "" for what is no readable regular file."""
    digest = hashlib.sha256()
    try:
        # Opening a pipe would wait for its other end.
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb", buffering=0) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return ""
            while data := file.read(_CHUNK):
                digest.update(data)
                if stop is not None and stop.is_set():
                    return ""
    except (OSError, ValueError):
        return ""
    return digest.hexdigest()


class Hashing:
    """Begins at once. Results are index and hash, in any order."""

    def __init__(self, paths: Sequence[str], threads: int) -> None:
        self._paths, self._left = paths, len(paths)
        self._next = iter(range(len(paths)))
        self._lock, self._stop = threading.Lock(), threading.Event()
        self._results: queue.SimpleQueue[tuple[int, str]] = queue.SimpleQueue()
        for _ in range(min(threads, len(paths))):
            threading.Thread(target=self._work, name="trimray-hash", daemon=True).start()

    def _work(self) -> None:
        while not self._stop.is_set():
            with self._lock:
                k = next(self._next, None)
            if k is None:
                return
            self._results.put((k, sha256_of(self._paths[k], self._stop)))

    def ready(self, seconds: float = 0.0) -> Iterator[tuple[int, str]]:
        """What was not told yet of what is known now, or after so many seconds at most."""
        until = time.monotonic() + seconds
        while self._left:
            try:
                left = until - time.monotonic()
                result = self._results.get(timeout=left) if left > 0 else self._results.get_nowait()
            except queue.Empty:
                return
            self._left -= 1
            yield result

    def rest(self) -> Iterator[tuple[int, str]]:
        """All that was not told yet; waits for it."""
        while self._left:
            try:
                result = self._results.get(timeout=_LOOK_SECONDS)  # short, so that Ctrl-C is heard
            except queue.Empty:
                continue
            self._left -= 1
            yield result

    def close(self) -> None:
        self._stop.set()
