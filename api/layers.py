"""The layers of a model's file: the part of Model that needs its store and its names alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ._core import Store


@dataclass(frozen=True)
class Layer:
    """What a file puts on one layer.

    faces: their numbers, ascending: single faces, and all faces of parts that are on the layer wherever they
    stand. instances: numbers of those that are on it in their place, or within an assembly that is.
    """

    faces: tuple[int, ...]
    instances: tuple[int, ...]


class Layered:
    """Layers by name."""

    _core: Store

    if TYPE_CHECKING:

        @property
        def _meta(self) -> dict[str, Any]: ...

    @cached_property
    def layers(self) -> Mapping[str, Layer]:
        """Name of a layer -> what is on it; {} where the file has none, or its format knows none."""
        by_shape: dict[int, list[int]] = {}
        named: dict[str, Any] = self._meta.get("layers", {})
        if any(entry.get("shapes") for entry in named.values()):
            for number, shape in enumerate(self._core.face_shapes().tolist()):
                by_shape.setdefault(shape, []).append(number)
        ranges = self._core.prototype_faces().tolist()
        found = {}
        for name, entry in named.items():
            faces = set(map(int, entry.get("faces", ())))
            for part in entry.get("prototypes", ()):
                faces.update(range(*ranges[part]))
            for shape in entry.get("shapes", ()):
                faces.update(by_shape.get(shape, ()))
            found[name] = Layer(tuple(sorted(faces)), tuple(map(int, entry.get("instances", ()))))
        return found
