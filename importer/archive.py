"""Compressed input (.stpZ, .step.gz, .stp.zip ...): unpacked into a folder, within a size limit."""

import os
import re
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from .errors import InputError, MemoryLimitError
from .formats import MODELS, SNIFF_BYTES, Format, extension, names_model, sniff

# Nothing grows beyond this, whatever the caller's memory limit: a guard against decompression bombs.
_MOST_UNPACKED_BYTES = 4 << 30
_CHUNK = 1 << 20
_WRAPPERS = {".gz": "", ".zip": "", ".stpz": ".stp", ".ifczip": "", ".z": ""}


def unpack(
    path: Path, kind: Format, folder: Path, *, name: str, memory_limit: int | None
) -> tuple[Path, str]:
    """Unpacks a gzip or zip file into ``folder``.

    Returns the path of the model and its name within the archive. All models of a zip file are
    unpacked side by side, so that external references resolve.
    Raises InputError for damaged or foreign content, MemoryLimitError when the content is too large.
    """
    limit = min(_MOST_UNPACKED_BYTES, memory_limit or _MOST_UNPACKED_BYTES)
    try:
        if kind == "gzip":
            return _unpack_gzip(path, folder, name, limit)
        return _unpack_zip(path, folder, name, limit)
    except (zlib.error, zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError, OSError) as error:
        raise InputError(f"{name}: damaged {kind} archive: {error}") from None


def inner_name(name: str) -> str:
    """Name of the model inside ``name``: "a.step.gz" -> "a.step", "a.stpZ" -> "a.stp"."""
    suffix = extension(name)
    if suffix not in _WRAPPERS:
        return name
    stem = name[: -len(suffix)] + _WRAPPERS[suffix]
    return stem if extension(stem) else stem + ".stp"


def is_model_name(name: str) -> bool:
    """Does the name say that a model is in the file, compressed or not: "A.STEP", "a.stp.gz", "a.stpZ"? What
    is in "a.zip" it leaves open."""
    suffix = extension(name)
    if suffix in _WRAPPERS:
        return names_model(name[: -len(suffix)] + _WRAPPERS[suffix])
    return names_model(name)


def _unpack_gzip(path: Path, folder: Path, name: str, limit: int) -> tuple[Path, str]:
    inner = inner_name(os.path.basename(name))
    target = folder / _safe(inner)
    inflate = zlib.decompressobj(wbits=31)
    size = 0
    with path.open("rb") as source, target.open("wb") as out:
        while chunk := source.read(_CHUNK):
            while chunk:
                data = inflate.decompress(chunk, _CHUNK)
                size += len(data)
                _check_size(size, limit, name)
                out.write(data)
                chunk = inflate.unconsumed_tail
                if inflate.eof and inflate.unused_data[:2] == b"\x1f\x8b":  # the next member of the file
                    chunk, inflate = inflate.unused_data, zlib.decompressobj(wbits=31)
                elif inflate.eof:
                    chunk = b""
    if not inflate.eof:
        raise EOFError("it ends in the middle")
    return target, inner


def _unpack_zip(path: Path, folder: Path, name: str, limit: int) -> tuple[Path, str]:
    models: list[tuple[str, Path, int]] = []
    size = 0
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if member.is_dir() or PurePosixPath(member.filename).name.startswith("."):
                continue
            with archive.open(member) as source:
                head = source.read(SNIFF_BYTES)
                if sniff(head, member.filename, member.file_size) not in MODELS:
                    continue
                target = folder / _safe(PurePosixPath(member.filename).name)
                written = len(head)
                with target.open("wb") as out:
                    out.write(head)
                    while chunk := source.read(_CHUNK):
                        written += len(chunk)
                        _check_size(size + written, limit, name)
                        out.write(chunk)
            size += written
            models.append((member.filename, target, written))
    if not models:
        raise InputError(
            f"{name}: no STEP, IGES or BREP file in the archive, nor triangles (STL, OBJ, PLY, OFF)"
        )
    return _main_member(models, name)


def _main_member(models: list[tuple[str, Path, int]], name: str) -> tuple[Path, str]:
    """The member named like the archive, else the one no other refers to, else the largest."""
    wanted = inner_name(os.path.basename(name)).lower()
    for member, path, _ in models:
        if PurePosixPath(member).name.lower() == wanted:
            return path, member
    if len(models) > 1:
        texts = {path: path.read_bytes() for _, path, size in models if size < (16 << 20)}
        roots = [m for m in models if not any(m[1].name.encode() in t for p, t in texts.items() if p != m[1])]
        models = roots or models
    member, path, _ = max(models, key=lambda entry: entry[2])
    return path, member


def _check_size(size: int, limit: int, name: str) -> None:
    if size > limit:
        raise MemoryLimitError(f"{name}: unpacks to more than {limit / 2**20:.0f} MiB")


def _safe(name: str) -> str:
    """A file name that stays in its folder."""
    return re.sub(r"[/\\\0]", "_", name).lstrip(".") or "model"
