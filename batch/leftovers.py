"""Temporary files of pictures that were being written when their process was killed."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable

# As trimray.image_io.write_file names them.
_NAME = re.compile(r"\.(.*)\.[0-9a-f]{12}\.part", re.DOTALL)


def remove_leftover_of(target: str) -> None:
    """What a process left of one picture, while others are written. Keeps what may be of another one, whose
    long name begins alike."""
    from trimray.image_io import temporary_stem

    folder, name = os.path.split(os.path.realpath(target))
    if temporary_stem(name) == name:
        remove_leftovers(folder, [name])


def remove_leftovers(folder: str, targets: Iterable[str]) -> list[str]:
    """targets: relative to the folder; nobody may be about to write them. Returns the paths removed."""
    from trimray.image_io import temporary_stem

    names: dict[str, set[str]] = {}
    for target in targets:
        parent, _, name = target.rpartition("/")
        names.setdefault(parent, set()).add(temporary_stem(name))
    removed: list[str] = []
    for parent, stems in names.items():
        place = os.path.join(folder, parent) if parent else folder
        try:
            with os.scandir(place) as entries:
                found = [e.path for e in entries if (m := _NAME.fullmatch(e.name)) and m[1] in stems]
        except OSError:
            continue  # no picture was written there yet
        for path in found:
            try:
                os.unlink(path)
            except OSError:
                continue
            removed.append(path)
    return removed
