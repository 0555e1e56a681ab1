"""An Inspection as a JSON-able message from the child, and back."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from .inspection import (
    Count,
    Edges,
    Fault,
    Inspection,
    Lost,
    Mass,
    Prototype,
    Topology,
    ValidationProperty,
)

_COLUMNS: dict[str, tuple[type[np.generic], tuple[int, ...]]] = {
    "prototype": (np.int32, (-1,)),
    "edge": (np.int32, (-1,)),
    "faces": (np.int32, (-1, 2)),
    "uses": (np.int32, (-1,)),
    "length": (np.float64, (-1,)),
    "tolerance": (np.float64, (-1,)),
    "deviation": (np.float64, (-1,)),
    "gap": (np.float64, (-1,)),
    "angle": (np.float64, (-1,)),
    "smooth": (np.bool_, (-1,)),
}
_LISTS: dict[str, type[Any]] = {
    "counts": Count,
    "lost": Lost,
    "properties": ValidationProperty,
    "faults": Fault,
}


def edges_of(columns: dict[str, list[Any]]) -> Edges:
    """Columns as lists, by name; one that is absent is empty."""
    return Edges(
        **{
            name: np.array(columns.get(name, []), dtype=dtype).reshape(shape)
            for name, (dtype, shape) in _COLUMNS.items()
        }
    )


def message_of(inspection: Inspection) -> dict[str, Any]:
    """JSON-able; whole, other than ``Inspection.as_dict``."""
    message: dict[str, Any] = {f.name: _plain(getattr(inspection, f.name)) for f in fields(inspection)}
    return message


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    return value


def inspection_of(message: dict[str, Any]) -> Inspection:
    """Raises ValueError, KeyError or TypeError when it does not hold together."""
    facts = dict(message)
    for name, kind in _LISTS.items():
        facts[name] = tuple(kind(**_tuples(entry)) for entry in facts[name])
    facts["topology"] = Topology(**facts["topology"])
    facts["mass"] = Mass(**_tuples(facts["mass"]))
    facts["prototypes"] = tuple(
        Prototype(
            name=entry["name"],
            instances=entry["instances"],
            faces=tuple(entry["faces"]),
            topology=Topology(**entry["topology"]),
            mass=Mass(**_tuples(entry["mass"])),
        )
        for entry in facts["prototypes"]
    )
    facts["edges"] = edges_of(facts["edges"])
    facts["face_areas"] = np.array(facts["face_areas"], dtype=np.float64)
    return Inspection(**facts)


def _tuples(entry: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()}
