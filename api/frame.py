"""Frame: a picture as named planes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from .views import AOVS, MAKING_AOVS

Plane = npt.NDArray[np.float32] | npt.NDArray[np.float64] | npt.NDArray[np.int32]


class Frame(Mapping[str, npt.NDArray[Any]]):
    """A rendered picture; ``frame["depth"]`` is one of its planes, rows from the top.

    color: (h, w, 4) float32, sRGB-encoded, straight alpha, filtered over the pixel.
    depth: (h, w) float64, mm along the pixel's ray, from the image plane (orthographic) or the eye; inf:
        nothing.
    position: (h, w, 3) float64, mm, world. normal: (h, w, 3) float64, unit, outward geometric normal, world.
    uv: (h, w, 2) float64, parameters of the file's surface.
    face, instance: (h, w) int32; -1: nothing.
    time: (h, w) float32, ns of processor time; it is measured by blocks of 8 x 8 pixels, which are traced
        each for itself, and never the same twice.
    seed_id: (h, w) uint32: what the raster pass saw, 0 for nothing; equal numbers are equal surfaces, or
        triangles with seed_process "id". seed_uv: (h, w, 2) float32, there, as fractions of the surface's
        range of parameters.
    All but color and time belong to the one ray through the pixel's centre and are never filtered; where it
    meets nothing, position, normal and uv are 0.
    """

    def __init__(self, planes: dict[str, npt.NDArray[Any]], size: tuple[int, int]) -> None:
        self._planes = planes
        self.width, self.height = size

    @property
    def aovs(self) -> tuple[str, ...]:
        """Names of the planes that were asked for."""
        return tuple(self._planes)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name not in self._planes and name in (*AOVS, *MAKING_AOVS):
            raise KeyError(f"'{name}' was not rendered: ask for it with aovs=")
        return self._planes[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._planes)

    def __len__(self) -> int:
        return len(self._planes)

    def __repr__(self) -> str:
        return f"<Frame {self.width} x {self.height}: {', '.join(self._planes)}>"

    def save(self, path: str | os.PathLike[str] | IO[bytes], *, format: str | None = None) -> None:
        """Writes the picture: the colour as PNG, JPEG, WebP or TIFF, or every plane as EXR (named channels).

        Where a plane other than the colour was rendered, and alone, the first four show it in false colours:
        numbers in colours of their own, parameters as red and green, normals and positions as red, green and
        blue, the depth in grey, the time from black over red to white, 30 ns to 30 us on a logarithmic scale
        that is the same for all pictures. Nothing is black.

        path: a file, or an open binary stream. format: "png", "jpeg", "webp", "tiff" or "exr"; by default
        the one of the path's extension. The file appears whole or not at all, and equal frames give equal
        bytes. Raises OutputError; UsageError for an unknown format, and where it cannot
        hold the picture.
        """
        from . import image_io

        image_io.save(self, path, format)
