"""MeshModel: the record that leaves the importer for files of triangles, as BrepModel does for B-reps."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .model import Float32s, Float64s, Int32s, json_text


@dataclass(frozen=True)
class MeshModel:
    """One part in one place. Each group of triangles becomes one face. Arrays are C-contiguous."""

    vertices: Float64s  # (n, 3) mm
    triangles: Int32s  # (m, 3) into vertices, turned as in the file
    group_ends: Int32s  # (g,) one past the last triangle of each group
    group_colors: Float32s  # (g, 4) sRGB-encoded, straight alpha; a negative red: none
    group_names: tuple[str, ...] = ()
    name: str = ""  # of the part
    source: dict[str, Any] = field(default_factory=dict)
    report: dict[str, Any] = field(default_factory=dict)

    def meta(self) -> dict[str, Any]:
        """JSON-able, with the keys of BrepModel.meta; faces are named by their number."""
        return {
            "unit": "mm",
            "unit_mm": 1.0,
            "prototypes": [{"name": self.name}],
            "instances": [{"name": self.name, "path": [self.name], "node": 0}],
            "tree": [
                {
                    "name": self.name,
                    "parent": -1,
                    "prototype": 0,
                    "placement": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
                }
            ],
            "named_faces": {str(i): name for i, name in enumerate(self.group_names) if name},
            "report": self.report,
            "source": self.source,
        }

    def meta_json(self) -> str:
        return json_text(self.meta())

    def validate(self) -> None:
        """Raises ValueError naming the first field whose type or shape is wrong; indices are checked where
        the store is made."""
        groups = len(self.group_ends)
        for name, dtype, shape in (
            ("vertices", np.float64, (len(self.vertices), 3)),
            ("triangles", np.int32, (len(self.triangles), 3)),
            ("group_ends", np.int32, (groups,)),
            ("group_colors", np.float32, (groups, 4)),
        ):
            array = getattr(self, name)
            if array.dtype != dtype or array.shape != shape or not array.flags.c_contiguous:
                raise ValueError(f"{name}: {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
        if len(self.group_names) != groups:
            raise ValueError("group_names: one per group")
