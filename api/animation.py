"""Frames to moving pictures. The only module that knows Pillow."""

from __future__ import annotations

import io
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

from .image_io import byte_pixels
from .importer.errors import OutputError, UsageError

if TYPE_CHECKING:
    from .frame import Frame


def encode_animation(frames: Iterable[Frame], format: str, fps: float) -> bytes:
    """The bytes of a WebP (lossless) or GIF (256 colours a frame, hundredths of a second) that repeats for
    ever. Equal frames give equal bytes. Raises UsageError, OutputError, and what making the frames raises.
    """
    try:
        from PIL import Image
    except ImportError as error:
        raise OutputError(f"{format}: needs the package pillow: {error}") from None
    images = []
    for frame in frames:
        names, pixels = byte_pixels(frame)
        if format == "gif" and len(names) == 4:
            raise UsageError("gif has no soft transparency: choose webp or another background")
        images.append(Image.fromarray(pixels))
    if format == "webp" and len({image.mode for image in images}) > 1:
        images = [image.convert("RGBA") for image in images]
    data = io.BytesIO()
    options = {"lossless": True, "method": 3} if format == "webp" else {"optimize": False, "disposal": 1}
    try:
        images[0].save(
            data,
            format=format.upper(),
            save_all=True,
            append_images=images[1:],
            duration=_durations(len(images), fps, 10 if format == "gif" else 1),
            loop=0,
            **options,
        )
    except (OSError, ValueError) as error:
        raise OutputError(f"{format}: {error}") from None
    return data.getvalue()


def _durations(count: int, fps: float, step: int) -> list[int]:
    """ms of each frame, in multiples of step, so that every frame begins within half a step of its time."""
    begins = [step * round(1000.0 * k / fps / step) for k in range(count + 1)]
    return [max(b - a, step) for a, b in pairwise(begins)]
