"""The test that is running, as far as the assertions ask: where its file is, and what pytest was told.

Without the plugin, as under unittest, it is the function that called the assertion. Imported by every run of
pytest on a machine that has trimray: nothing heavy belongs here.
"""

from __future__ import annotations

import os
import re
import sys
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

FAILURES = ".trimray-failures"
# Keys of pytest's user_properties: they travel from the workers of pytest-xdist to where the summary is made.
PICTURE, FAILURE = "trimray_picture", "trimray_failure"
_LONGEST = 120


@dataclass
class Running:
    """id: of the test. folder: of its file. root: what messages show paths from.

    update: renew golden pictures. report: folder for what failures leave; chosen: by the user.
    notes: (key, value) for the summary. failures: how many have been saved.
    """

    id: str
    folder: Path
    root: Path
    report: Path
    chosen: bool = False
    update: bool = False
    notes: list[tuple[str, object]] = field(default_factory=list)
    failures: int = 0

    def beside(self, path: str | os.PathLike[str]) -> Path:
        """A path as written in the test file, from the folder of that."""
        return self.folder / os.path.expanduser(os.fspath(path))

    def model(self, source: Any) -> Any:
        """A model to be read: a relative path that exists beside the test file alone is that one, and a
        builder of build123d is what it has built."""
        if isinstance(source, str | os.PathLike) and not os.path.exists(source):
            near = self.beside(source)
            return near if near.exists() else source
        if not hasattr(source, "wrapped") and hasattr(getattr(source, "part", None), "wrapped"):
            return source.part
        return source

    def shown(self, path: Path) -> str:
        """A path for messages: from the root where it is below it."""
        absolute = Path(os.path.abspath(path))
        return str(absolute.relative_to(self.root) if absolute.is_relative_to(self.root) else absolute)

    def folder_name(self) -> str:
        """Of what a failure leaves: readable, one for each test, and fit for every file system."""
        plain = re.sub(r"[^\w.-]+", "-", self.id, flags=re.ASCII).strip("-.")[-_LONGEST:]
        simple = len(self.id) <= _LONGEST and re.fullmatch(r"[\w./:-]+", self.id, flags=re.ASCII)
        return plain if plain and simple else f"{plain}-{zlib.crc32(self.id.encode(errors='replace')):08x}"


_Maker = Callable[[], Running]
_current: Running | _Maker | None = None


def enter(running: Running | _Maker | None) -> Running | _Maker | None:
    """Makes it the current one, or what makes it when it is asked for; the one before it is returned."""
    global _current
    before, _current = _current, running
    return before


def here() -> Running:
    global _current
    if _current is None:
        return _caller()
    if not isinstance(_current, Running):
        _current = _current()
    return _current


def _caller() -> Running:
    """Of the innermost function outside of trimray."""
    frame = sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).startswith("trimray."):
        frame = frame.f_back
    file = Path(os.path.abspath(frame.f_code.co_filename))
    root = Path.cwd()
    return Running(f"{file.name}::{frame.f_code.co_name}", file.parent, root, root / FAILURES)
