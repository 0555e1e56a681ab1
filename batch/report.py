"""What became of every file, as JSON lines."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator

from .state import Row

# Of a row, under the same names and in this order.
_FACTS = (
    *("status", "exit_code", "reason", "sha256", "size", "mtime_ns", "drawn", "not_drawn", "covered"),
    *("seconds", "peak_memory", "attempt"),
)


def lines(rows: Iterable[Row], folder: str) -> Iterator[bytes]:
    """One object a row. folder: of the pictures. ASCII: bytes of paths that are no UTF-8 stand as
    \\udc80 to \\udcff, which os.fsencode of Python turns back into them."""
    for row in rows:
        yield json.dumps(entry(row, folder), separators=(", ", ": ")).encode() + b"\n"


def entry(row: Row, folder: str) -> dict[str, object]:
    """A row in the words of the report. output: absolute, null where there is no picture."""
    facts = row.as_dict()
    there = row.target and row.status not in ("failed", "pending")
    result: dict[str, object] = {
        "input": row.path,
        "output": os.path.join(folder, row.target) if there else None,
    }
    for name in _FACTS:
        result[name] = facts[name]
    result["finished"] = row.finished or None
    result["trimray"] = row.version
    result["settings"] = json.loads(row.settings) if row.settings else None
    return result


def write_report(path: str, rows: Iterable[Row], folder: str) -> None:
    """path: of the file to write, whole or not at all. Raises OutputError."""
    from trimray.image_io import write_file

    write_file(path, lines(rows, folder))
