"""Did anything get lost? Two models compared in structure, topology, mass, geometry and pictures.

comparison = trimray.fidelity.compare("part.step", "converted.step")
comparison.verdict, comparison.differences()
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .comparing import compare
    from .record import Comparison, Finding, Picture, Verdict
    from .side import Side, read
    from .tolerances import PROFILES, Tolerances

__all__ = [
    "PROFILES",
    "Comparison",
    "Finding",
    "Picture",
    "Side",
    "Tolerances",
    "Verdict",
    "compare",
    "read",
]

_HOME = {
    "compare": "comparing",
    "Comparison": "record",
    "Finding": "record",
    "Picture": "record",
    "Verdict": "record",
    "Side": "side",
    "read": "side",
    "PROFILES": "tolerances",
    "Tolerances": "tolerances",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value
