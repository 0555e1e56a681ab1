"""BrepModel: the record that leaves the importer.

The shapes are one BinTools stream (``brep``); everything that the stream cannot say stands in small arrays
beside it, the very ones of core/nurbs/build_store.h. Shape indices are 1-based positions in the stream.
Lengths are mm, whatever the file's unit. Colours are sRGB-encoded RGBA in [0, 1], straight alpha; a negative
red means none. A face is drawn in its own colour, else the instance's, else the prototype's.
"""

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

Int32s = npt.NDArray[np.int32]
Float32s = npt.NDArray[np.float32]
Float64s = npt.NDArray[np.float64]

NO_COLOR = (-1.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class TreeNode:
    """A node of the assembly tree; parents stand before their children.

    parent: index of a node, -1 at a root. prototype: index, -1 for an assembly.
    placement: (12,) rows of the 3x4 matrix from this node to its parent.
    """

    name: str
    parent: int
    prototype: int
    placement: tuple[float, ...]


@dataclass(frozen=True)
class Instance:
    """Names of a placed prototype; its numbers are in the arrays of BrepModel at the same index."""

    name: str
    path: tuple[str, ...]  # names from the root down to this instance
    node: int  # index into BrepModel.tree


@dataclass(frozen=True)
class BrepModel:
    """A model as the importer leaves it. Arrays are C-contiguous and not to be written to."""

    brep: bytes  # BinTools_ShapeSet, version 4, without triangulations of faces that have a surface
    prototype_shapes: Int32s  # (p,) root shape of each prototype
    prototype_colors: Float32s  # (p, 4)
    face_color_shapes: Int32s  # (c,) faces that carry a colour of their own
    face_colors: Float32s  # (c, 4)
    instance_prototypes: Int32s  # (n,)
    instance_placements: Float64s  # (n, 12) rows of the 3x4 matrix, prototype -> world
    instance_colors: Float32s  # (n, 4)
    prototype_names: tuple[str, ...] = ()
    face_names: dict[int, str] = field(default_factory=dict)  # shape index -> name
    # name -> {"prototypes": [..], "instances": [..], "shapes": [..]} that are on a layer; shapes are faces
    layers: dict[str, dict[str, list[int]]] = field(default_factory=dict)
    instances: tuple[Instance, ...] = ()
    tree: tuple[TreeNode, ...] = ()
    unit: str = "mm"  # of the file
    unit_mm: float = 1.0
    source: dict[str, Any] = field(default_factory=dict)  # name, format, schema, originating system ...
    report: dict[str, Any] = field(default_factory=dict)  # report.Report.as_dict()

    def meta(self) -> dict[str, Any]:
        """JSON-able: all that the store carries without reading it."""
        return {
            "unit": self.unit,
            "unit_mm": self.unit_mm,
            "prototypes": [{"name": name} for name in self.prototype_names],
            "instances": [{"name": i.name, "path": list(i.path), "node": i.node} for i in self.instances],
            "tree": [
                {"name": n.name, "parent": n.parent, "prototype": n.prototype, "placement": list(n.placement)}
                for n in self.tree
            ],
            "face_names": {str(shape): name for shape, name in self.face_names.items()},
            "layers": self.layers,
            "report": self.report,
            "source": self.source,
        }

    def meta_json(self) -> str:
        """``meta()`` as the UTF-8 text that build_store takes."""
        return json_text(self.meta())

    def validate(self) -> None:
        """Raises ValueError naming the first field whose type, shape or range is wrong."""
        prototypes, instances = len(self.prototype_shapes), len(self.instance_prototypes)
        for name, dtype, shape in (
            ("prototype_shapes", np.int32, (prototypes,)),
            ("prototype_colors", np.float32, (prototypes, 4)),
            ("face_color_shapes", np.int32, (len(self.face_color_shapes),)),
            ("face_colors", np.float32, (len(self.face_color_shapes), 4)),
            ("instance_prototypes", np.int32, (instances,)),
            ("instance_placements", np.float64, (instances, 12)),
            ("instance_colors", np.float32, (instances, 4)),
        ):
            array = getattr(self, name)
            if array.dtype != dtype or array.shape != shape or not array.flags.c_contiguous:
                raise ValueError(f"{name}: {array.dtype} {array.shape}, expected {np.dtype(dtype)} {shape}")
            if not np.isfinite(array).all():
                raise ValueError(f"{name}: not finite")
        if not self.brep:
            raise ValueError("brep: empty")
        if (self.prototype_shapes < 1).any() or (self.face_color_shapes < 1).any():
            raise ValueError("shape index below 1")
        if ((self.instance_prototypes < 0) | (self.instance_prototypes >= prototypes)).any():
            raise ValueError("instance_prototypes: out of range")
        if len(self.prototype_names) != prototypes or len(self.instances) != instances:
            raise ValueError("names: one per prototype and instance")
        for index, node in enumerate(self.tree):
            if (
                not -1 <= node.parent < index
                or not -1 <= node.prototype < prototypes
                or len(node.placement) != 12
            ):
                raise ValueError(f"tree[{index}]: out of range")
        if any(not 0 <= instance.node < len(self.tree) for instance in self.instances):
            raise ValueError("instances: node out of range")


def json_text(meta: dict[str, Any]) -> str:
    """As compact JSON; what stands for bytes of a file's name that are no UTF-8 becomes U+FFFD."""
    text = json.dumps(meta, ensure_ascii=False, separators=(",", ":"))
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
