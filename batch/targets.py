"""Which picture is whose: paths by a template, no two files with one, none too long for a file system."""

from __future__ import annotations

import hashlib
import os
import string
import unicodedata
from collections import Counter
from collections.abc import Sequence

from trimray import UsageError
from trimray.formats import EXTENSIONS, extension_of, format_of, split_name
from trimray.views import did_you_mean

from .find import File

FIELDS = ("parent", "name", "ext", "format")
STATE_NAME = "trimray-batch"

_MOST_BYTES = 255  # of one name, on every usual file system


def format_of_template(template: str | None, format: str | None) -> str:
    """The format asked for, else the one of the template's extension, else png. Raises UsageError."""
    if format is not None:
        return format_of("", format)
    extension = os.path.splitext(template or "")[1].lower()
    return EXTENSIONS.get(extension, "png")


class Template:
    """text: a path with fields: {parent} is the file's folder relative to the PATH it was found under, {name}
    the file's name without its extensions, {ext} its extension, {format} that of the picture. Raises
    UsageError."""

    def __init__(self, text: str | None, format: str) -> None:
        self._format = extension_of(format)
        self._text = "{parent}/{name}.{format}" if text is None else text
        self._check()

    def _check(self) -> None:
        text = self._text
        try:
            parts = list(string.Formatter().parse(text))
        except ValueError as error:
            raise UsageError(f"--template: '{text}': {error}") from None
        for _, name, spec, conversion in parts:
            if name is not None and name not in FIELDS:
                hint = did_you_mean(name, FIELDS) or f", one of: {', '.join(FIELDS)}"
                raise UsageError(f"--template: unknown field '{{{name}}}'{hint}")
            if spec or conversion:
                raise UsageError(f"--template: '{{{name}}}' takes nothing after its name")
        if "\0" in text or not text or text.endswith("/"):
            raise UsageError(f"--template: '{text}' names no file")
        if text.startswith("/") or ".." in text.split("/"):
            raise UsageError(f"--template: '{text}' leaves the folder of the pictures")

    def __call__(self, file: File, *, full_name: bool = False, mark: str = "") -> str:
        """Relative to the folder of the pictures. full_name: {name} with its extensions. mark: of the last
        part of the path, before its extension."""
        stem, extension = split_name(file.name)
        words = {
            "parent": file.parent,
            "name": file.name if full_name else stem,
            "ext": extension,
            "format": self._format,
        }
        parts = [part for part in self._text.format(**words).split("/") if part not in ("", ".", "..")]
        if mark and parts:
            root, last = os.path.splitext(parts[-1])
            parts[-1] = f"{root}~{mark}{last}"
        return "/".join(_shortened(part) for part in parts)


def targets(files: Sequence[File], template: Template) -> list[str]:
    """A path relative to the folder of the pictures for each file, all different.

    Where two would be the same, both take their full names (part.step.png, part.iges.png); where that does
    not help, a mark made from their paths. Depends on the files alone, not on their order.
    """
    result = [template(file) for file in files]
    for again in (_full_name, _marked, _marked_in_full):
        clashes = _clashes(result)
        if not clashes:
            break
        for k in clashes:
            result[k] = again(template, files[k])
    return result


def _full_name(template: Template, file: File) -> str:
    return template(file, full_name=True)


def _marked(template: Template, file: File) -> str:
    return template(file, full_name=True, mark=_hash(file.path, 8))


def _marked_in_full(template: Template, file: File) -> str:
    return template(file, full_name=True, mark=_hash(file.path, 32))


def _clashes(paths: list[str]) -> list[int]:
    """Which are not alone, or also a folder of others, or a file that a batch writes beside the pictures; on
    file systems that ignore case, too."""
    keys = [_key(path) for path in paths]
    counts = Counter(keys)
    folders: set[str] = set()
    for path in keys:
        parent = path.rpartition("/")[0]
        while parent and parent not in folders:
            folders.add(parent)
            parent = parent.rpartition("/")[0]
    return [k for k, path in enumerate(keys) if counts[path] > 1 or path in folders or _reserved(path)]


def _key(path: str) -> str:
    """The same for paths that some file system takes for one, however letters are cased and composed."""
    if path.isascii():
        return path.lower()
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", path).casefold())


def _reserved(path: str) -> bool:
    return not path or path == "index.html" or (path.startswith(STATE_NAME) and ".sqlite" in path)


def _shortened(part: str) -> str:
    """A name that is too long keeps its beginning and its extension."""
    data = os.fsencode(part)
    if len(data) <= _MOST_BYTES:
        return part
    extension = os.path.splitext(part)[1]
    tail = f"~{_hash(part, 8)}" + (extension if len(os.fsencode(extension)) <= 16 else "")
    head = data[: _MOST_BYTES - len(os.fsencode(tail))]
    while head and (data[len(head)] & 0xC0) == 0x80:  # not in the middle of a character
        head = head[:-1]
    return os.fsdecode(head) + tail


def _hash(text: str, digits: int) -> str:
    return hashlib.sha256(os.fsencode(text)).hexdigest()[:digits]
