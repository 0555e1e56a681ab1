"""trimray: exact pictures of STEP and IGES files, and watertight meshes of them.

    model = trimray.load("part.step")
    model.render((1024, 768), view="iso").save("part.png")
    model.tessellate("0.05mm").save("part.stl")
    hits = model.cast(origins, directions)
    distances = model.distance(points)

Lengths are mm, angles radians unless a name says otherwise. Every error is a ``trimray.Error``; its
subclasses are UsageError, InputError (and EmptyError), OutputError, LimitError (TimeLimitError,
MemoryLimitError).

Names are imported when first used, so that ``import trimray`` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from .version import __version__

if TYPE_CHECKING:
    from .camera import Camera
    from .distances import Distances, EdgeSamples, Samples
    from .faces import Face, Instance, Layer
    from .fidelity.comparing import compare
    from .frame import Frame
    from .hits import Hits
    from .importer.errors import (
        EmptyError,
        Error,
        InputError,
        LimitError,
        MemoryLimitError,
        OutputError,
        TimeLimitError,
        UsageError,
    )
    from .importer.inspect_file import inspect
    from .importer.inspection import Inspection
    from .loading import load
    from .mass_properties import MassProperties
    from .merging import merge
    from .model import Model
    from .report import Issue, Report
    from .tri_mesh import MeshCheck, MeshIssue, TriMesh
    from .views import AOVS

__all__ = [
    "AOVS",
    "Camera",
    "Distances",
    "EdgeSamples",
    "EmptyError",
    "Error",
    "Face",
    "Frame",
    "Hits",
    "InputError",
    "Inspection",
    "Instance",
    "Issue",
    "Layer",
    "LimitError",
    "MassProperties",
    "MemoryLimitError",
    "MeshCheck",
    "MeshIssue",
    "Model",
    "OutputError",
    "Report",
    "Samples",
    "TimeLimitError",
    "TriMesh",
    "UsageError",
    "__version__",
    "compare",
    "inspect",
    "load",
    "merge",
]

_HOME = {
    "load": "loading",
    "compare": "fidelity.comparing",
    "merge": "merging",
    "TriMesh": "tri_mesh",
    "MeshCheck": "tri_mesh",
    "MeshIssue": "tri_mesh",
    "Model": "model",
    "Camera": "camera",
    "Distances": "distances",
    "EdgeSamples": "distances",
    "Samples": "distances",
    "Face": "faces",
    "Instance": "faces",
    "Frame": "frame",
    "AOVS": "views",
    "Hits": "hits",
    "MassProperties": "mass_properties",
    "Report": "report",
    "Issue": "report",
    "Layer": "faces",
    "inspect": "importer.inspect_file",
    "Inspection": "importer.inspection",
} | {name: "importer.errors" for name in __all__ if name.endswith("Error")}


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'trimray' has no attribute '{name}'")
    value = getattr(importlib.import_module(f".{home}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
