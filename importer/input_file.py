"""What is to be read: the kind of a file, unpacked where it is compressed. Knows no reader."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import archive
from .formats import SNIFF_BYTES, Format, sniff
from .report import Report


@dataclass(frozen=True)
class InputFile:
    """path: of plain content. source: facts about it for BrepModel.source."""

    path: str
    kind: Format
    source: dict[str, Any]


def open_input(path: str, *, name: str, folder: str, memory_limit: int | None, report: Report) -> InputFile:
    """name: what messages call the file; its extension decides where the content does not. folder: scratch
    space. Raises InputError, MemoryLimitError."""
    source: dict[str, Any] = {"name": os.path.basename(name), "bytes": os.path.getsize(path)}
    kind = kind_of(path, name)
    if kind not in ("gzip", "zip"):
        return InputFile(_utf8_path(path, folder), kind, source)
    with report.stage("unpack"):
        unpacked, inner = archive.unpack(Path(path), kind, Path(folder), name=name, memory_limit=memory_limit)
    source["archive"], source["member"] = kind, inner
    return InputFile(str(unpacked), kind_of(str(unpacked), inner), source)


def kind_of(path: str, name: str) -> Format:
    with open(path, "rb") as file:
        return sniff(file.read(SNIFF_BYTES), name, os.path.getsize(path))


def _utf8_path(path: str, folder: str) -> str:
    """The absolute path, or one by links in folder where its bytes are no UTF-8: the readers take no other.
    Given a relative one, OpenCascade looks for external files in a folder that is not there. The folder is
    linked rather than the file where that will do, so that files are found that this one refers to."""
    path = os.path.abspath(path)
    if _is_utf8(path):
        return path
    parent, name = os.path.split(path)
    if not _is_utf8(parent):
        os.symlink(parent, os.path.join(folder, "folder"))
        parent = os.path.join(folder, "folder")
    if _is_utf8(name):
        return os.path.join(parent, name)
    link = os.path.join(folder, "input")
    os.symlink(os.path.join(parent, name), link)
    return link


def _is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True
