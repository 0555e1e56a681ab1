"""Camera: from where a picture looks at a model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _core


@dataclass(frozen=True, eq=False)
class Camera:
    """Made by ``Model.camera``; ``Model.render`` and ``Model.tessellate`` take it as their view."""

    _core: _core.Camera

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture, px."""
        return self._core.width_px, self._core.height_px

    @property
    def perspective(self) -> bool:
        return self._core.perspective

    @property
    def eye(self) -> npt.NDArray[np.float64]:
        """(3,) float64, mm, world; orthographic: the centre of the image plane."""
        return self._core.eye

    @property
    def right(self) -> npt.NDArray[np.float64]:
        """(3,) float64, unit: x of the picture."""
        return self._core.right

    @property
    def up(self) -> npt.NDArray[np.float64]:
        """(3,) float64, unit: against y of the picture, which runs down."""
        return self._core.up

    @property
    def forward(self) -> npt.NDArray[np.float64]:
        """(3,) float64, unit: where the centre of the picture looks."""
        return self._core.forward

    @property
    def pixel(self) -> float:
        """Width of a pixel: mm (orthographic), or mm at a distance of 1 mm (perspective)."""
        return self._core.pixel

    def rays(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Origins and unit directions, (height, width, 3) float64, of the pixels' centres, for ``cast``."""
        shape = (self._core.height_px, self._core.width_px, 3)
        origins, directions = self._core.rays()
        return origins.reshape(shape), directions.reshape(shape)

    def __repr__(self) -> str:
        kind = "perspective" if self.perspective else "orthographic"
        return f"<Camera: {self.size[0]} x {self.size[1]} px, {kind}>"
