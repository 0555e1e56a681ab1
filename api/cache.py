"""The cache of imported models: one file a model under $XDG_CACHE_HOME/trimray, safe to delete at any time.

A file is named by SHA-256 of the input's bytes, the options that change the result, the version and the
build. It holds what the store's own format does not (tight bounds, outline points, seconds) as JSON, then
the store. A damaged or foreign file counts as absent. No error of the cache ever reaches the user: a cache
that cannot be written costs time only.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .version import __version__

_MAGIC = b"TRIMRAY-CACHE-1\n"
_HEAD = struct.Struct("<16sIQ")  # magic, CRC-32 and length of the JSON


@dataclass(frozen=True)
class Entry:
    facts: dict[str, Any]
    store: bytes


def folder() -> Path:
    """$XDG_CACHE_HOME/trimray, by default ~/.cache/trimray. Relative values are ignored, as XDG demands."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(base) if os.path.isabs(base) else Path.home() / ".cache") / "trimray"


def key(data: bytes, extension: str, options: dict[str, Any]) -> str:
    """data: of the input file. extension: decides how a file without a clear beginning is read."""
    digest = hashlib.sha256()
    for part in (
        data,
        extension.lower().encode(),
        json.dumps(options, sort_keys=True).encode(),
        _build().encode(),
    ):
        digest.update(struct.pack("<Q", len(part)))
        digest.update(part)
    return digest.hexdigest()


def _build() -> str:
    """The version, and the native core's and the importer's files: two builds of one version share
    nothing."""
    here = Path(__file__).parent
    files = [p for p in here.iterdir() if p.name.startswith("_core.") and p.suffix == ".so"]
    files += (p for p in (here / "importer").iterdir() if p.suffix == ".py")
    stats = ((p.name, p.stat()) for p in sorted(files))
    return __version__ + "".join(f"|{name},{s.st_size},{s.st_mtime_ns}" for name, s in stats)


def read(name: str) -> Entry | None:
    """None when there is no such file, or it is not what write() wrote."""
    try:
        data = (folder() / name[:2] / name).read_bytes()
        magic, checksum, length = _HEAD.unpack_from(data)
        text = data[_HEAD.size : _HEAD.size + length]
        if magic != _MAGIC or len(text) != length or zlib.crc32(text) != checksum:
            return None
        facts = json.loads(text)
        return Entry(facts, data[_HEAD.size + length :]) if isinstance(facts, dict) else None
    except (OSError, ValueError, struct.error, RuntimeError):
        return None


def write(name: str, entry: Entry) -> bool:
    """True when the file is in its place."""
    try:
        target = folder() / name[:2] / name
        folder().parent.mkdir(parents=True, exist_ok=True)
        for private in (folder(), target.parent):
            private.mkdir(exist_ok=True, mode=0o700)
        text = json.dumps(entry.facts, separators=(",", ":")).encode()
        temporary = target.with_name(f".{name}.{os.urandom(6).hex()}")
        try:
            with open(temporary, "xb") as file:
                file.write(_HEAD.pack(_MAGIC, zlib.crc32(text), len(text)) + text)
                file.write(entry.store)
            os.replace(temporary, target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        return True
    except (OSError, RuntimeError):
        return False


def size() -> tuple[int, int]:
    """Number of models kept, and their bytes."""
    try:
        sizes = [p.stat().st_size for p in folder().glob("??/*") if len(p.name) == 64]
    except (OSError, RuntimeError):
        return 0, 0
    return len(sizes), sum(sizes)
