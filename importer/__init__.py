"""Reads CAD files into BrepModel; the only part that knows OpenCascade.

Importing this package does not import OCP: files are read in a child process. Nor does it import NumPy:
the reader and its model are imported when first used, since a cached picture needs only the errors.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from .errors import (
    EmptyError,
    Error,
    InputError,
    LimitError,
    MemoryLimitError,
    OutputError,
    TimeLimitError,
    UsageError,
)

if TYPE_CHECKING:
    from .mesh_model import MeshModel
    from .model import BrepModel, Instance, TreeNode
    from .reader import read_model

__all__ = [
    "BrepModel",
    "EmptyError",
    "Error",
    "InputError",
    "Instance",
    "LimitError",
    "MemoryLimitError",
    "MeshModel",
    "OutputError",
    "TimeLimitError",
    "TreeNode",
    "UsageError",
    "read_model",
]

_HOME = {
    "BrepModel": "model",
    "Instance": "model",
    "TreeNode": "model",
    "MeshModel": "mesh_model",
    "read_model": "reader",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value
