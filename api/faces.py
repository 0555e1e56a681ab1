"""What a model is made of, as its users see it: faces, placed parts, layers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np
import numpy.typing as npt

Color = tuple[float, float, float, float]


@dataclass(frozen=True)
class Face:
    """One face of one part.

    number: its index in ``model.faces``, and what the AOV ``face`` and ``hits.face`` hold.
    kind: of its surface: "plane", "cylinder", "cone", "sphere", "torus", "extrusion", "revolution", "bezier",
        "bspline", "offset", or "none" (nothing exact in the file).
    color: (red, green, blue, alpha) in [0, 1], sRGB-encoded, straight alpha: its own, else the one of the
        first place where its part stands; None where the file gives none (it is then drawn in a neutral
        grey).
    name: from the file, often "". part: name of its part.
    status: "ok", or the reason it cannot be drawn.
    """

    number: int
    kind: str
    color: Color | None
    name: str
    part: str
    status: str

    @property
    def what(self) -> str:
        """For messages: "plane of Lid", by its own name or that of its part."""
        owner = self.name or self.part
        return f"{self.kind} of {owner}" if owner else self.kind

    def call(self) -> str:
        """For messages: "face 12 (plane of Lid)"."""
        return f"face {self.number} ({self.what})"


@dataclass(frozen=True)
class Instance:
    """A part at a place in the world.

    number: what the AOV ``instance`` and ``hits.instance`` hold. name, part: from the file. path: names from
    the root of the assembly down to it. faces: numbers of its faces. placement: (3, 4) float64, part to
    world, mm. color: as of a Face, of those faces that have none of their own.
    """

    number: int
    name: str
    part: str
    path: tuple[str, ...]
    faces: range
    placement: npt.NDArray[np.float64]
    color: Color | None


@dataclass(frozen=True)
class Layer:
    """What a file puts on one layer.

    faces: their numbers, ascending: single faces, and all faces of parts that are on the layer wherever they
    stand. instances: numbers of those that are on it in their place, or within an assembly that is.
    """

    faces: tuple[int, ...]
    instances: tuple[int, ...]


class Faces(Sequence[Face]):
    """All faces, made when asked for: a list of a hundred thousand objects would cost more than the
    picture."""

    def __init__(
        self,
        kinds: list[str],
        statuses: list[str],
        colors: npt.NDArray[np.float32],
        parts: npt.NDArray[np.int32],
        part_names: list[str],
        part_colors: dict[int, Color | None],
        names: dict[int, str],
    ) -> None:
        self._kinds, self._statuses, self._colors = kinds, statuses, colors
        self._parts, self._part_names, self._part_colors, self._names = parts, part_names, part_colors, names

    def __len__(self) -> int:
        return len(self._kinds)

    @overload
    def __getitem__(self, index: int) -> Face: ...
    @overload
    def __getitem__(self, index: slice) -> list[Face]: ...
    def __getitem__(self, index: int | slice) -> Face | list[Face]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        number = index + len(self) if index < 0 else index
        if not 0 <= number < len(self):
            raise IndexError(f"face {index} of {len(self)}")
        part = int(self._parts[number])
        return Face(
            number=number,
            kind=self._kinds[number],
            color=color_or_none(self._colors[number]) or self._part_colors.get(part),
            name=self._names.get(number, ""),
            part=self._part_names[part] if part < len(self._part_names) else "",
            status=self._statuses[number],
        )

    def __iter__(self) -> Iterator[Face]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<{len(self)} faces>"


def color_or_none(rgba: npt.NDArray[np.float32]) -> Color | None:
    """The store's convention, a negative red, as None."""
    if rgba[0] < 0:
        return None
    red, green, blue, alpha = (float(x) for x in rgba)
    return (red, green, blue, alpha)
