"""Frames to image files. The only module that knows OpenImageIO."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .false_colors import false_colors
from .formats import FORMATS, check_fit, format_of
from .importer.errors import InputError, OutputError, UsageError
from .version import __version__

if TYPE_CHECKING:
    from .frame import Frame

__all__ = ["FORMATS", "check_fit", "decode", "encode", "format_of", "preload", "save", "write_file"]

# Format -> OpenImageIO's name of it.
_WRITERS = {name: name for name in FORMATS} | {"exr": "openexr"}

# EXR channels of each plane; layers bear the AOV's name.
CHANNELS = {
    "color": ("R", "G", "B", "A"),
    "depth": ("depth.Z",),
    "position": ("position.X", "position.Y", "position.Z"),
    "normal": ("normal.X", "normal.Y", "normal.Z"),
    "uv": ("uv.U", "uv.V"),
    "face": ("face.I",),
    "instance": ("instance.I",),
    "seed_id": ("seed_id.I",),
    "seed_uv": ("seed_uv.U", "seed_uv.V"),
    "time": ("time.ns",),
}

# float32 holds every integer up to here, so ids keep their value (and -1 for nothing) in a float channel.
_MAX_EXACT_ID = 1 << 24


def save(frame: Frame, path: str | os.PathLike[str] | IO[bytes], format: str | None) -> None:
    """Writes a frame, whole or not at all. Raises OutputError, UsageError."""
    if not isinstance(path, str | os.PathLike):
        path.write(encode(frame, format_of("", format or "png")))
        return
    data = encode(frame, format_of(path, format))
    write_file(os.fspath(path), data)


def preload() -> None:
    """Imports OpenImageIO, which takes as long as a small picture, in the background."""

    threading.Thread(target=import_library, name="trimray-preload").start()


def import_library() -> None:
    """Imports OpenImageIO now; encode says what is wrong where it cannot be."""
    with contextlib.suppress(ImportError):
        import OpenImageIO  # noqa: F401


def encode(frame: Frame, format: str, *, text: Mapping[str, str] | None = None) -> bytes:
    """The bytes of the image file: exr holds every plane, the other formats the colour, or the one plane that
    there is in false colours. Equal frames give equal bytes.

    text: keys and values in ASCII to store in a PNG, such as those of the freedesktop thumbnail cache.
    Raises UsageError, OutputError.
    """
    if text and format != "png":
        raise UsageError(f"{format}: text keys are written into PNG alone")
    if format == "exr":
        return _encode(format, *_exr_pixels(frame))
    names, pixels = byte_pixels(frame)
    check_fit(format, ("color",) if "color" in frame else frame.aovs, len(names) == 3)
    return _encode(format, names, pixels, text)


def byte_pixels(frame: Frame) -> tuple[tuple[str, ...], npt.NDArray[np.uint8]]:
    """Names and 8 bits a channel: the colour, with straight alpha where it says anything, or else the first
    plane in false colours."""
    if "color" not in frame:
        return CHANNELS["color"][:3], false_colors(frame.aovs[0], frame[frame.aovs[0]])
    opaque = bool(frame["color"][..., 3].min() >= 1.0)
    names = CHANNELS["color"][: 3 if opaque else 4]
    color = frame["color"][..., : len(names)]
    return names, np.ascontiguousarray((np.clip(color, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))


def _exr_pixels(frame: Frame) -> tuple[tuple[str, ...], npt.NDArray[Any]]:
    """float32; colour linear with associated alpha, as EXR wants it."""
    names: list[str] = []
    planes: list[npt.NDArray[Any]] = []
    for aov in frame.aovs:
        plane = frame[aov]
        if aov == "color":
            alpha = plane[..., 3:].astype(np.float64)
            plane = np.concatenate([_linear(plane[..., :3].astype(np.float64)) * alpha, alpha], axis=-1)
        if plane.dtype in (np.int32, np.uint32) and plane.size and int(plane.max()) > _MAX_EXACT_ID:
            raise UsageError(f"exr: {aov} numbers above {_MAX_EXACT_ID} do not fit its float channels")
        planes.append(plane.reshape(frame.height, frame.width, -1).astype(np.float32))
        names.extend(CHANNELS[aov])
    return tuple(names), np.ascontiguousarray(np.concatenate(planes, axis=-1))


def _linear(encoded: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _encode(
    format: str, names: tuple[str, ...], pixels: npt.NDArray[Any], text: Mapping[str, str] | None = None
) -> bytes:
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, "uint8" if pixels.dtype == np.uint8 else "float")
    spec.channelnames = names
    spec.alpha_channel = names.index("A") if "A" in names else -1
    spec.attribute("Software", f"trimray {__version__}")
    spec.attribute("oiio:ColorSpace", "lin_rec709_scene" if format == "exr" else "srgb_rec709_scene")
    # An empty date keeps OpenImageIO from writing the present one.
    spec.attribute("DateTime", _date())
    spec.attribute("oiio:UnassociatedAlpha", 1 if format != "exr" else 0)
    for key, value in (text or {}).items():
        spec.attribute(key, value)
    if format == "png":
        spec.attribute("png:filter", 16)  # "sub": half the time of libpng's choice, and smaller CAD pictures
    elif format == "webp":
        spec.attribute("compression", "lossless")
    elif format == "jpeg":
        spec.attribute("compression", "jpeg:95")
        spec.attribute("jpeg:subsampling", "4:4:4")
    elif format in ("tiff", "exr"):
        spec.attribute("compression", "zip")
    with _scratch() as (descriptor, name):
        output = oiio.ImageOutput.create(_WRITERS[format])
        if output is None:
            raise OutputError(f"{format}: this OpenImageIO ({oiio.VERSION_STRING}) does not write it")
        if not (output.open(name, spec) and output.write_image(pixels) and output.close()):
            raise OutputError(f"{format}: {output.geterror() or 'OpenImageIO failed'}")
        return _content(descriptor)


# Pixels of a picture to be read; a header may claim any number.
_MOST_PIXELS = 1 << 28


def decode(data: bytes, name: str = "the picture") -> tuple[npt.NDArray[np.uint8], dict[str, str]]:
    """The pixels of a PNG, (h, w, 4) uint8 with straight alpha, and its text keys. Raises InputError."""
    import OpenImageIO as oiio

    if not data.startswith(b"\x89PNG\r\n\x1a\n"):
        raise InputError(f"{name}: not a PNG picture")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    with _scratch() as (descriptor, path):
        os.pwrite(descriptor, data, 0)
        source = oiio.ImageInput.open(path, config)
        if source is None:
            raise InputError(f"{name}: a broken PNG picture: {oiio.geterror()}")
        spec = source.spec()
        sound = spec.width * spec.height <= _MOST_PIXELS and 1 <= spec.nchannels <= 4
        pixels = source.read_image("uint8") if sound else None
        source.close()
    if pixels is None:
        raise InputError(f"{name}: a broken PNG picture, or too large")
    if spec.nchannels < 3:  # grey, perhaps with alpha
        pixels = np.concatenate([np.repeat(pixels[..., :1], 3, axis=-1), pixels[..., 1:]], axis=-1)
    if pixels.shape[-1] == 3:
        pixels = np.pad(pixels, ((0, 0), (0, 0), (0, 1)), constant_values=255)
    texts = {a.name: a.value for a in spec.extra_attribs if isinstance(a.value, str)}
    return np.ascontiguousarray(pixels), texts


@contextmanager
def _scratch() -> Iterator[tuple[int, str]]:
    """An unnamed file in memory that OpenImageIO can open by a path; a temporary file where there is no
    memfd."""
    if hasattr(os, "memfd_create") and os.path.isdir("/proc/self/fd"):
        descriptor = os.memfd_create("trimray")
        try:
            yield descriptor, f"/proc/self/fd/{descriptor}"
        finally:
            os.close(descriptor)
    else:
        import tempfile

        with tempfile.NamedTemporaryFile(prefix="trimray-") as file:
            yield file.fileno(), file.name


def _content(descriptor: int) -> bytes:
    size = os.fstat(descriptor).st_size
    return os.pread(descriptor, size, 0) if size < (1 << 30) else _long_content(descriptor, size)


def _long_content(descriptor: int, size: int) -> bytes:
    """One pread gives at most 2 GiB."""
    parts = [os.pread(descriptor, 1 << 30, at) for at in range(0, size, 1 << 30)]
    return b"".join(parts)


def _date() -> str:
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not epoch.isdigit():
        return ""
    try:
        return datetime.fromtimestamp(int(epoch), UTC).strftime("%Y:%m:%d %H:%M:%S")
    except (OverflowError, ValueError, OSError):
        return ""


def write_file(path: str, data: bytes | Iterable[bytes], *, mode: int = 0o666) -> None:
    """Puts data, or the parts of it, at path: beside it under a temporary name, then renamed, so that nobody
    ever sees a half of it.

    mode: permissions of the file, less the process's umask. A device or a pipe is written to directly. Raises
    OutputError; nothing is left behind.
    """
    try:
        target = os.path.realpath(path)
        if os.path.exists(target) and not stat.S_ISREG(os.stat(target).st_mode):
            if os.path.isdir(target):
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
            with open(target, "wb") as device:
                device.writelines(_parts(data))
            return
        if os.path.exists(target) and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        _replace(target, data, mode)
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: not written: {getattr(error, 'strerror', None) or error}") from None


def temporary_stem(name: str) -> str:
    """What the temporary name of a file begins with, after a dot; with the rest no longer than a file system
    takes."""
    return os.fsdecode(os.fsencode(name)[:200])


def _parts(data: bytes | Iterable[bytes]) -> Iterable[bytes]:
    return [data] if isinstance(data, bytes) else data


def _replace(target: str, data: bytes | Iterable[bytes], mode: int) -> None:
    folder, name = os.path.split(target)
    temporary = os.path.join(folder, f".{temporary_stem(name)}.{os.urandom(6).hex()}.part")
    try:
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode)
        with open(descriptor, "wb") as file:
            file.writelines(_parts(data))
        os.replace(temporary, target)
    except BaseException:
        if os.path.lexists(temporary):
            os.unlink(temporary)
        raise
