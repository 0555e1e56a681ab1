"""Which image formats there are, and what fits into each. Knows no picture, so it costs nothing to ask."""

from __future__ import annotations

import os

from .importer.errors import UsageError
from .views import did_you_mean

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
