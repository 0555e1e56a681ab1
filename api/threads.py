"""How many threads the native core takes where nothing says it."""

from __future__ import annotations

import os


def use_one_thread() -> None:
    """Keeps the native core of this process to one thread, for good, also where its functions take no number
    of threads. To be called before anything else of it; later it is of no effect.

    oneTBB sizes its pool once, by the processors that are open to the process when it is first used; so it is
    used once while one alone is open, and no processor is chosen for what follows.
    """
    import numpy as np

    from . import _core

    if not hasattr(os, "sched_setaffinity"):
        return
    processors = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(processors)})
    except OSError:
        return
    try:
        triangle = _core.Store.from_triangles(
            np.eye(3),
            np.arange(3, dtype=np.int32)[None],
            np.ones(1, np.int32),
            np.full((1, 4), -1, np.float32),
            "{}",
        )
        _core.Scene(triangle)
    finally:
        os.sched_setaffinity(0, processors)
