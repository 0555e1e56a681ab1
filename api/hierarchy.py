"""Hierarchy: a store made ready for rays, once."""

from __future__ import annotations

import contextlib
import threading
import time

from . import _core


class Hierarchy:
    """Makes the Scene of a store when first asked, or ahead of that in the background. From any thread."""

    def __init__(self, store: _core.Store) -> None:
        self.store = store
        self.seconds: float | None = None  # that making it took; None: not made yet
        self._scene: _core.Scene | None = None
        self._lock = threading.Lock()

    def begin(self) -> None:
        """Starts to make it. The thread is no daemon: native code must not outlive the interpreter."""
        threading.Thread(target=self._try, name="trimray-hierarchy").start()

    def scene(self) -> _core.Scene:
        """The Scene, as soon as it is made."""
        with self._lock:
            if self._scene is None:
                start = time.perf_counter()
                self._scene = _core.Scene(self.store)
                self.seconds = time.perf_counter() - start
            return self._scene

    def _try(self) -> None:
        # Whoever asks for the scene tries again, and hears of the error.
        with contextlib.suppress(Exception):
            self.scene()
