"""Which formats of pictures and meshes there are, how their files are named, and what fits into each.

Knows no picture, so it costs nothing to ask.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable

from .importer.errors import UsageError
from .views import did_you_mean

_PACKED = (".gz", ".z", ".zip")
_SHORT = {"jpeg": "jpg", "tiff": "tif"}

FORMATS = ("png", "jpeg", "webp", "tiff", "exr")
EXTENSIONS = {
    ".png": "png",
    ".jpg": "jpeg",
    ".jpeg": "jpeg",
    ".webp": "webp",
    ".tif": "tiff",
    ".tiff": "tiff",
    ".exr": "exr",
}


def extension_of(format: str) -> str:
    """What the name of a file of this format ends with, without the dot."""
    return _SHORT.get(format, format)


def split_name(name: str) -> tuple[str, str]:
    """Stem and extension without the dot: "part.step.gz" -> ("part", "step.gz")."""
    root, extension = os.path.splitext(name)
    if extension.lower() in _PACKED:
        root, inner = os.path.splitext(root)
        extension = inner + extension
    return (root, extension[1:]) if root else (name, "")


def format_of(path: str | os.PathLike[str], format: str | None = None) -> str:
    """The format of FORMATS to write: the one asked for, else the one of the extension. Raises UsageError."""
    if format is not None:
        name = {"jpg": "jpeg", "tif": "tiff"}.get(format.lower(), format.lower())
    else:
        extension = os.path.splitext(os.fspath(path))[1].lower()
        if not extension:
            raise UsageError(
                f"{os.fspath(path)}: no extension to choose a format by; give one of: {', '.join(FORMATS)}"
            )
        name = EXTENSIONS.get(extension, extension[1:])
    if name in FORMATS:
        return name
    if name in ("avif", "heic", "heif"):
        raise UsageError(
            f"{name.upper()} is not written: the OpenImageIO wheel lacks it; use webp, png or exr"
        )
    raise UsageError(
        f"unknown picture format '{name}'{did_you_mean(name, FORMATS) or ','} one of: {', '.join(FORMATS)}"
    )


ANIMATIONS = ("webp", "gif")
_NUMBER = re.compile(r"%(0?[1-9])?d")


def numbered(path: str) -> Callable[[int], str] | None:
    """Where a path has %d, %04d or the like in it, the paths by number. Raises UsageError for several."""
    found = _NUMBER.findall(path)
    if len(found) > 1:
        raise UsageError(f"{path}: one number only, such as %04d")
    if not found:
        return None
    width = int(found[0] or 0)
    return lambda number: _NUMBER.sub(f"{number:0{width}d}", path)


def sequence_format_of(path: str, format: str | None = None) -> str:
    """The format of a turntable: of FORMATS where the path is numbered, else of ANIMATIONS. Raises
    UsageError."""
    if numbered(path) is not None:
        return format_of(path, format)
    name = (format or os.path.splitext(path)[1][1:]).lower()
    if name in ANIMATIONS:
        return name
    raise UsageError(
        f"'{name or path}' holds no frames: write webp or gif, or numbered pictures, such as %04d.png"
    )


def check_sequence(format: str, aovs: tuple[str, ...], opaque: bool) -> None:
    """As check_fit."""
    if format == "gif":
        check_fit("png", aovs, opaque)
        if "color" in aovs and not opaque:
            raise UsageError("gif has no soft transparency: choose webp or another background")
    else:
        check_fit(format, aovs, opaque)


MESH_FORMATS = ("stl", "ply", "obj", "off", "glb")


def mesh_format_of(path: str | os.PathLike[str], format: str | None = None) -> str:
    """The format of MESH_FORMATS to write: the one asked for, else the one of the extension. Raises
    UsageError."""
    name = (format or os.path.splitext(os.fspath(path))[1][1:]).lower()
    if name in MESH_FORMATS:
        return name
    if not name:
        raise UsageError(
            f"{os.fspath(path)}: no extension to choose a format by; give one of: {', '.join(MESH_FORMATS)}"
        )
    raise UsageError(
        f"unknown mesh format '{name}'{did_you_mean(name, MESH_FORMATS) or ','}"
        f" one of: {', '.join(MESH_FORMATS)}"
    )


def check_fit(format: str, aovs: tuple[str, ...], opaque: bool) -> None:
    """Raises UsageError when a picture with these planes cannot go into the format: before it is rendered,
    not after."""
    if format != "exr" and len(aovs) > 1:
        raise UsageError(f"{format} holds one plane only, not {', '.join(aovs)}: write exr")
    if format == "jpeg" and not opaque and "color" in aovs:
        raise UsageError("jpeg has no transparency: choose another format or background")
