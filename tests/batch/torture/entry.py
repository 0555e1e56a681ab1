"""What the library holds, and what must become of it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

# good: must be drawn, as `trimray render` draws it. bad: must fail. either: a mutant, whose fate is what a
# single `trimray render` says. absent: no input at all, and must not be named.
Expect = Literal["good", "bad", "either", "absent"]


@dataclass(frozen=True)
class Entry:
    """path: below the library. reason: a regular expression that the reason must match. alias: holds the same
    bytes as that model, and looks the same."""

    path: bytes
    kind: str
    expect: Expect
    reason: str = ""
    alias: str = ""

    @property
    def shown(self) -> str:
        return os.fsdecode(self.path)


def write(root: Path, entry: Entry, data: bytes) -> Entry:
    """Makes the file and its folders."""
    path = os.path.join(os.fsencode(root), entry.path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data)
    return entry
