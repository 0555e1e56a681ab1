"""draw_file in a worker, with what it cost and what the worker holds afterwards."""

from __future__ import annotations

import json
import resource
from dataclasses import replace
from pathlib import Path

from trimray.batch.draw import draw_file
from trimray.batch.record import Item, Outcome, Settings


def measured(item: Item, settings: Settings) -> Outcome:
    """The reason is JSON: seconds of processor time, bytes of memory, and the reason."""
    before = seconds()
    outcome = draw_file(item, settings)
    own, children = (after - b for after, b in zip(seconds(), before, strict=True))
    facts = {"reason": outcome.reason, "own": own, "children": children, **memory()}
    return replace(outcome, reason=json.dumps(facts))


def seconds() -> tuple[float, float]:
    """Processor time of this process and of those of its children that have ended."""
    own, children = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime, children.ru_utime + children.ru_stime


def memory() -> dict[str, int]:
    """Bytes of this process: rss, pss, anonymous."""
    names = {"Rss:": "rss", "Pss:": "pss", "Anonymous:": "anonymous"}
    lines = (line.split() for line in Path("/proc/self/smaps_rollup").read_text().splitlines())
    return {names[line[0]]: int(line[1]) * 1024 for line in lines if line[0] in names}
