"""trimray batch merge: the states of the shards of a batch become one."""

from __future__ import annotations

from typing import Any

from trimray import UsageError

from .output import say


def run(inputs: tuple[str, ...], options: dict[str, Any]) -> int:
    """Returns the exit code. options: of the table, by name."""
    if len(inputs) != 1:
        raise UsageError("batch merge takes one DIR, that of the pictures; a folder named merge is ./merge")
    from trimray.batch.merge import merge

    from .batch import tell_summary, write_results

    merged = merge(inputs[0], gallery=options["gallery"])
    for shards, what in ((merged.missing, "missing"), (merged.unfinished, "not finished")):
        if shards:
            names = ", ".join(map(str, shards[:20])) + (" ..." if len(shards) > 20 else "")
            say(f"shards {what}: {names}", error=True)
    tell_summary(merged.summary, options["quiet"])
    write_results(merged.summary.state, merged.summary.run, inputs[0], options)
    return merged.summary.exit_code
