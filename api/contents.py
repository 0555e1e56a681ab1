"""What a model holds, whatever is asked of it: faces, placed parts, layers, unit, bounds, report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .faces import Face, Faces, Instance, Layer, color_or_none
from .hierarchy import Hierarchy
from .importer.errors import EmptyError
from .report import Report, make_report


class Contents:
    """The part of Model that only reads: the store's arrays, and what the file says beside the surfaces."""

    def __init__(
        self,
        hierarchy: Hierarchy,
        *,
        seconds: dict[str, float],
        extent: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]] | None = None,
        cached: bool = False,
        source: str = "",
    ) -> None:
        """source: what messages call the model, "" for "the model"."""
        self._hierarchy = hierarchy
        self._core = hierarchy.store
        self._source = source or "the model"
        self._seconds = seconds
        self._cached = cached
        if extent is not None:
            self.__dict__["_extent"] = extent

    def __repr__(self) -> str:
        return f"<Model: {len(self.faces)} faces, {len(self.instances)} instances>"

    @cached_property
    def _meta(self) -> dict[str, Any]:
        meta = json.loads(self._core.meta or "{}")
        return meta if isinstance(meta, dict) else {}

    @cached_property
    def _extent(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Tight bounds (2, 3) and outline points (n, 3); the bounds are inf, -inf when nothing can be
        drawn."""
        return self._core.extent()

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3) float64, mm: lower and upper corner of the tight box, in the world, of all faces that can
        be drawn.

        Raises EmptyError when there is none.
        """
        bounds = self._extent[0]
        if not np.isfinite(bounds).all():
            raise EmptyError(f"{self._source}: no face can be drawn: {_first(self.report.reasons())}")
        return bounds.copy()

    @property
    def unit(self) -> str:
        """The length unit of the file, such as "mm" or "in". Every length in the API is mm, whatever the
        file's unit."""
        return str(self._meta.get("unit", "mm"))

    @cached_property
    def faces(self) -> Sequence[Face]:
        """All faces, in the order of their numbers, those that cannot be drawn included."""
        parts = self._core.instance_prototypes()
        colors = self._core.instance_colors()
        first = {
            int(part): color_or_none(color) for part, color in zip(parts[::-1], colors[::-1], strict=True)
        }
        return Faces(
            self._core.face_kinds(),
            self._core.face_statuses(),
            self._core.face_colors(),
            self._core.face_prototypes(),
            self._part_names,
            first,
            self._face_names,
        )

    @cached_property
    def _face_names(self) -> dict[int, str]:
        """By number, of the faces that have one."""
        names = {int(n): str(text) for n, text in self._meta.get("named_faces", {}).items()}
        by_shape = self._meta.get("face_names", {})
        if by_shape:
            for number, shape in enumerate(self._core.face_shapes().tolist()):
                if str(shape) in by_shape:
                    names[number] = str(by_shape[str(shape)])
        return names

    @cached_property
    def _part_names(self) -> list[str]:
        return [str(p.get("name", "")) for p in self._meta.get("prototypes", ())]

    @cached_property
    def instances(self) -> Sequence[Instance]:
        """Every place where a part stands, in the order of their numbers."""
        parts, ranges = self._core.instance_prototypes().tolist(), self._core.prototype_faces().tolist()
        colors, placements = self._core.instance_colors(), self._core.instance_placements()
        named = list(self._meta.get("instances", ()))
        result = []
        for i, part in enumerate(parts):
            about = named[i] if i < len(named) else {}
            result.append(
                Instance(
                    number=i,
                    name=str(about.get("name", "")),
                    part=self._part_names[part] if part < len(self._part_names) else "",
                    path=tuple(str(x) for x in about.get("path", ())),
                    faces=range(*ranges[part]),
                    placement=placements[i],
                    color=color_or_none(colors[i]),
                )
            )
        return tuple(result)

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

    @property
    def report(self) -> Report:
        """What became of the file's faces, seconds per stage, peak memory."""
        undrawn = [i for i, status in enumerate(self._core.face_statuses()) if status != "ok"]
        source = self._meta.get("report", {})
        seconds = dict(self._seconds)
        if self._hierarchy.seconds is not None:
            seconds["hierarchy"] = self._hierarchy.seconds
        return make_report(
            (self.faces[i] for i in undrawn), self._core.face_count, source, seconds, self._cached
        )


def _first(reasons: list[str], few: int = 2) -> str:
    left = f"; and {len(reasons) - few} more" if len(reasons) > few else ""
    return "; ".join(reasons[:few]) + left
