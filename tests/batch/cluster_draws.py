"""What workers of the tests' clusters do: the real drawing, with misfortunes by the name of the file."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

from trimray.batch.draw import draw_file
from trimray.batch.record import Item, Outcome, Settings


def draw(item: Item, settings: Settings) -> Outcome:
    """Notes that it began, in a file beside the folder of pictures."""
    target = Path(item.target)
    with open(target.parent.parent / "begun", "ab") as begun:
        begun.write(os.fsencode(target.name.replace("\n", "_")) + b"\n")
    if "crash" in target.name:
        os.kill(os.getpid(), signal.SIGSEGV)
    if "hang" in target.name:
        time.sleep(3600)
    if "slow" in target.name:
        time.sleep(0.3)
    if "murder" in target.name:
        os.kill(_ancestor(3), signal.SIGKILL)  # server of workers, node, Dask's worker
        time.sleep(3600)
    # On a busy machine the limit, which is for the hang, would make good pictures coarse.
    return draw_file(item, replace(settings, time_limit=None))


def _ancestor(steps: int) -> int:
    pid = os.getpid()
    for _ in range(steps):
        status = Path(f"/proc/{pid}/status").read_text()
        pid = next(int(line.split()[1]) for line in status.splitlines() if line.startswith("PPid:"))
    return pid
