"""One of the two models of a comparison: read once, with what a comparison asks of it again and again."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

import trimray
from trimray.model import Model

if TYPE_CHECKING:
    from trimray.mass_properties import MassProperties

Float64s = npt.NDArray[np.float64]
Int64s = npt.NDArray[np.int64]

# What a format can hold beside shapes. What one of two formats cannot hold is no difference.
_EVERYTHING = frozenset({"names", "tree", "colors", "layers", "unit"})
HOLDS: dict[str, frozenset[str]] = {
    "step": _EVERYTHING,
    "iges": frozenset({"colors", "layers", "unit"}),
    "shape": frozenset({"names", "tree", "colors"}),
    "obj": frozenset({"names", "colors"}),
    "ply": frozenset({"colors"}),
}


@dataclass
class Side:
    """name: what messages call it. model: None where it could not be read; error then says why."""

    name: str
    model: Model | None
    error: str = ""
    empty: bool = False  # it was read, and holds no face
    failure: trimray.Error | None = None  # what reading it raised
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def sound(self) -> Model:
        """The model, where there is one."""
        assert self.model is not None, self.error
        return self.model

    @cached_property
    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Of the store, by their names in core/nurbs/store.h."""
        return self.sound._core.arrays()

    @cached_property
    def meta(self) -> dict[str, Any]:
        return self.sound._meta

    @cached_property
    def format(self) -> str:
        return str(self.meta.get("report", {}).get("format", ""))

    def holds(self, what: str) -> bool:
        """Can its format hold "names", "tree", "colors", "layers", "unit"?"""
        return what in HOLDS.get(self.format, frozenset())

    @cached_property
    def diagonal(self) -> float:
        """mm, of the bounds; 0 where nothing can be drawn."""
        bounds = self.sound._extent[0]
        return float(np.linalg.norm(bounds[1] - bounds[0])) if np.isfinite(bounds).all() else 0.0

    @cached_property
    def mass(self) -> MassProperties:
        return self.sound.mass_properties()

    @cached_property
    def prototypes(self) -> Int64s:
        """(n,) of the instances."""
        return self.arrays["instances"]["prototype"].astype(np.int64)

    @cached_property
    def placements(self) -> Float64s:
        """(n, 3, 4) of the instances, to the world."""
        return self.sound._core.instance_placements()

    @cached_property
    def uses(self) -> Int64s:
        """(p,): how often each prototype is placed."""
        return np.bincount(self.prototypes, minlength=len(self.arrays["prototypes"]))

    def owners(self, what: str) -> Int64s:
        """(n,) prototype of each of the "edges" or "vertices"."""
        spans = self.arrays["prototypes"][what]
        return np.repeat(np.arange(len(spans)), np.diff(spans, axis=1).ravel())

    def where(self, face: int) -> str:
        """ "face 12 (plane of Lid)"."""
        return self.sound.faces[face].call()


def placed(points: Float64s, placement: Float64s) -> Float64s:
    """(n, 3): points of a part in the world. placement: (3, 4)."""
    return points @ placement[:, :3].T + placement[:, 3]


def read(source: Any, *, name: str | None = None, **options: Any) -> Side:
    """A side from a path, bytes, a Model, a shape given in Python, or a Side, which it stays.

    options: of ``trimray.load``. What cannot be read is no exception: see Side.error. UsageError passes.
    """
    if isinstance(source, Side):
        return source
    if isinstance(source, Model):
        return _of_model(name or source._source, source)
    is_file = isinstance(source, str | os.PathLike | bytes)
    shown = name or (os.fsdecode(source) if isinstance(source, str | os.PathLike) else "")
    try:
        # Of a shape, the name would be taken for its part's.
        model = trimray.load(source, name=name if is_file else None, **options)
    except trimray.UsageError:
        raise
    except trimray.Error as error:
        empty = isinstance(error, trimray.EmptyError)
        return Side(shown or type(source).__name__, None, error=str(error), empty=empty, failure=error)
    return _of_model(shown or str(model._meta.get("source", {}).get("name", "")) or "the model", model)


def _of_model(name: str, model: Model) -> Side:
    side = Side(name, model)
    if not len(model.faces):
        side.error, side.empty = f"{name}: no faces", True
    return side
