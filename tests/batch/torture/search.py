"""Finds recipes of files that crash or hang OpenCascade: python -m tests.batch.torture.search SEEDS [WORD].

Each mutant is read in a fork of a process that imported OCP; prints the end, operation, seed and model. What
is found is written down in crashers.py by hand.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
import time
from pathlib import Path

from . import sources
from .mutate import OPERATIONS, Recipe

PATIENCE = 8  # seconds of processor time, and of the clock
MEMORY = 2 << 30


def end_of(path: Path, patience: int = PATIENCE) -> str:
    """How reading ends: "model", the name of an error, of a signal, or "hang"."""
    from trimray.importer.errors import Error
    from trimray.importer.read_file import read_file

    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        signal.alarm(patience)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        try:
            with tempfile.TemporaryDirectory() as folder:
                read_file(str(path), name=path.name, folder=folder)
        except Error:
            os._exit(3)
        except MemoryError:
            os._exit(5)
        except BaseException:
            os._exit(70)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    code = os.waitstatus_to_exitcode(status)
    if code == -signal.SIGALRM:
        return "hang"
    if code < 0:
        return signal.Signals(-code).name
    return {0: "model", 3: "error", 5: "memory"}.get(code, "foreign")


def main() -> None:
    from trimray.importer import read_file  # noqa: F401  imports OCP once, for all forks

    first, last = (int(word) for word in sys.argv[1].split("-"))
    only = sys.argv[2] if len(sys.argv) > 2 else ""
    small = [s for s in sources.all_sources() if s.size < 45_000 and only in s.name]
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, last):
            for source in small:
                for operation in OPERATIONS:
                    recipe = Recipe(source.name, operation, seed)
                    path = Path(folder) / recipe.name
                    path.write_bytes(recipe.make(source.read()))
                    start = time.perf_counter()
                    end = end_of(path)
                    took = time.perf_counter() - start
                    path.unlink()
                    print(f"{end}\t{operation}\t{seed}\t{source.name}\t{took:.2f}", flush=True)


if __name__ == "__main__":
    main()
