"""What a run would draw where, before anything is done."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

from trimray import UsageError
from trimray.formats import check_fit
from trimray.views import parse_background

from .find import File, absolute, find
from .record import Outcome, Settings
from .shard import Shard
from .targets import Template, targets


class Plan(NamedTuple):
    """files and targets (relative to the folder of the pictures) of a share. failures: folders that could not
    be searched. found: files and failures of all shares."""

    files: list[File]
    targets: list[str]
    failures: list[Outcome]
    found: int


def plan(
    paths: Sequence[str],
    output: str,
    settings: Settings,
    *,
    include: Sequence[str] = (),
    template: str | None = None,
    shard: Shard | None = None,
) -> Plan:
    """What a run would draw where. Raises UsageError."""
    check_fit(settings.format, ("color",), all(c[3] >= 1.0 for c in parse_background(settings.background)))
    form = Template(template, settings.format)
    folder, places = absolute(output), [absolute(path) for path in paths]
    found = find(places, include=include, leave_out=folder)
    aims = targets(found.files, form)
    _check_apart(found.files, aims, places, folder)
    number = len(found.files) + len(found.failures)
    if shard is None or shard.n == 1:
        return Plan(found.files, aims, found.failures, number)
    share = [k for k, file in enumerate(found.files) if file.relative in shard]
    return Plan([found.files[k] for k in share], [aims[k] for k in share], found.failures, number)


def _check_apart(files: list[File], aims: list[str], places: list[str], folder: str) -> None:
    """No picture may take the place of an input, as it might where inputs lie below the pictures' folder.
    Raises UsageError."""
    real = os.path.realpath(folder)
    if not any(os.path.realpath(place).startswith(f"{real}/") or place == folder for place in places):
        return
    inputs = {os.path.realpath(file.path) for file in files}
    for file, aim in zip(files, aims, strict=True):
        if os.path.join(real, aim) in inputs:
            raise UsageError(f"{file.path}: its picture would overwrite the input {aim}")
