"""Entries of the freedesktop thumbnail cache (Thumbnail Managing Standard): where they are, what they say.

A picture is $XDG_CACHE_HOME/thumbnails/SIZE/MD5.png, MD5 that of the file's URI; a failure is a picture of
one pixel in fail/trimray-VERSION/, so that a new version tries again. Both say in text keys of which file
they are, and when that was modified.
"""

from __future__ import annotations

import hashlib
import os
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass

from trimray import OutputError, __version__
from trimray.image_io import write_file

from .base_folders import base_folder
from .uris import file_uri

# Longest side of a picture by the folder of the cache, px.
SIZES = {"normal": 128, "large": 256, "x-large": 512, "xx-large": 1024}
# Our own keys, under a name of our own.
_CODE, _REASON = "X-trimray::ExitCode", "X-trimray::Reason"
# Text keys stand before the pixels; more than that is none of a sane entry.
_MAX_HEAD = 1 << 16


@dataclass(frozen=True)
class Original:
    """The file that an entry is of. mtime: whole seconds, as GIO has them. size: bytes."""

    uri: str
    mtime: int
    size: int

    @classmethod
    def of(cls, path: str) -> Original:
        """As the file is now. Raises OSError, ValueError for a NUL byte."""
        about = os.stat(path)
        return cls(file_uri(path), about.st_mtime_ns // 10**9, about.st_size)

    @property
    def name(self) -> str:
        """Of its entries."""
        return hashlib.md5(self.uri.encode(), usedforsecurity=False).hexdigest() + ".png"

    def keys(self) -> dict[str, str]:
        """The text keys of its entries."""
        return {
            "Thumb::URI": self.uri,
            "Thumb::MTime": str(self.mtime),
            "Thumb::Size": str(self.size),
        }


def cache_folder(environment: Mapping[str, str] = os.environ) -> str:
    """$XDG_CACHE_HOME/thumbnails, by default ~/.cache/thumbnails. Raises OutputError where there is no
    home."""
    base = base_folder(environment, "XDG_CACHE_HOME", ".cache")
    if base is None:
        raise OutputError("no cache: set HOME or XDG_CACHE_HOME")
    return os.path.join(base, "thumbnails")


def failure_folder(cache: str) -> str:
    return os.path.join(cache, "fail", f"trimray-{__version__}")


def make_private(folder: str) -> None:
    """Makes the folder and those above it that are missing, for the user alone. Raises OutputError."""
    missing = []
    while not os.path.isdir(folder):
        missing.append(folder)
        parent = os.path.dirname(folder)
        if parent == folder:
            break
        folder = parent
    for path in reversed(missing):
        try:
            os.mkdir(path, 0o700)
        except FileExistsError:
            if not os.path.isdir(path):
                raise OutputError(f"{path}: not a folder") from None
        except OSError as error:
            raise OutputError(f"{path}: not made: {error.strerror or error}") from None


def is_current(path: str, original: Original) -> bool:
    """Is there an entry of the file as it is now? By whomever; where it says no size, any will do."""
    keys = text_keys(path)
    wanted = original.keys()
    return keys is not None and all(
        keys.get(key, wanted[key] if key == "Thumb::Size" else None) == wanted[key] for key in wanted
    )


def text_keys(path: str) -> dict[str, str] | None:
    """Text keys of a PNG, those before its pixels; None when there is no such file."""
    try:
        with open(path, "rb") as file:
            head = file.read(_MAX_HEAD)
            whole = file.seek(0, os.SEEK_END)
            file.seek(max(0, whole - 12))
            end = file.read(12)
    except (OSError, ValueError):
        return None
    if not head.startswith(b"\x89PNG\r\n\x1a\n") or not end.endswith(b"IEND\xaeB`\x82"):
        return None
    keys: dict[str, str] = {}
    at = 8
    while at + 8 <= len(head):
        length, kind = struct.unpack_from(">I4s", head, at)
        content = head[at + 8 : at + 8 + length]
        if kind == b"IDAT" or len(content) < length:
            break
        if kind == b"tEXt":
            key, _, value = content.partition(b"\0")
            keys[key.decode("latin-1")] = value.decode("latin-1")
        at += 12 + length
    return keys


def failure_of(path: str) -> tuple[int, str]:
    """Exit code and reason that a failure's entry tells."""
    keys = text_keys(path) or {}
    code = keys.get(_CODE, "")
    return int(code) if code.isdigit() else 3, keys.get(_REASON, "failed before, and has not changed since")


def write_failure(path: str, original: Original, exit_code: int, reason: str) -> None:
    """Raises OutputError."""
    pixel = zlib.compress(bytes(5))  # one row: its filter, and one clear pixel
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 6, 0, 0, 0))]
    keys = {"Software": f"trimray {__version__}", _CODE: str(exit_code)} | original.keys()
    if reason:
        keys[_REASON] = " ".join(reason.split()).encode("ascii", "backslashreplace").decode()
    chunks += [(b"tEXt", f"{key}\0{value}".encode("latin-1")) for key, value in keys.items()]
    chunks += [(b"IDAT", pixel), (b"IEND", b"")]
    data = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )
    write_file(path, data, mode=0o600)
