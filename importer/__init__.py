"""Reads CAD files into BrepModel; the only part that knows OpenCascade.

Importing this package does not import OCP: files are read in a child process.
"""

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
    "OutputError",
    "TimeLimitError",
    "TreeNode",
    "UsageError",
    "read_model",
]
