"""SHA-256 of many files by a few threads, beside whatever else goes on."""

from __future__ import annotations

import hashlib
import os
import queue
import stat
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import FileIO

from trimray import InputError

_CHUNK = 1 << 20
_LOOK_SECONDS = 0.2


@contextmanager
def regular_file(path: str, name: str) -> Iterator[FileIO]:
    """Open to be read. name: what messages call it. Raises InputError, also where reading it fails."""
    try:
        # Not blocking, lest a pipe without a writer holds us.
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        try:
            mode = os.fstat(descriptor).st_mode
            if not stat.S_ISREG(mode):
                what = "is a directory" if stat.S_ISDIR(mode) else "not a regular file"
                raise InputError(f"{name}: {what}")
            with FileIO(descriptor, closefd=False) as file:
                yield file
        finally:
            os.close(descriptor)
    except (OSError, ValueError) as error:
        raise InputError(f"{name}: {getattr(error, 'strerror', None) or error}") from None


def sha256_of(path: str, stop: threading.Event | None = None) -> str:
    """Hex; "" for what is no readable regular file."""
    digest = hashlib.sha256()
    try:
        with regular_file(path, path) as file:
            while data := file.read(_CHUNK):
                digest.update(data)
                if stop is not None and stop.is_set():
                    return ""
    except InputError:
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

    def __enter__(self) -> Hashing:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
