"""Parts, their assembly tree, names and colours as an XCAF document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from OCP.gp import gp_Trsf
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from ..importer.model import NO_COLOR
from ..importer.occt import new_document
from ..importer.shapes import compound_of

Color = Sequence[float]  # sRGB-encoded, straight alpha; a negative red: none
_SURFACE = XCAFDoc_ColorType.XCAFDoc_ColorSurf
# How far the rows of a placement may be from an orthonormal right-handed frame.
_RIGID = 1e-9


@dataclass
class Part:
    """A prototype. faces: those with a colour or a name of their own, "" for no name."""

    shape: TopoDS_Shape
    name: str = ""
    color: Color = NO_COLOR
    faces: list[tuple[TopoDS_Shape, Color, str]] = field(default_factory=list)
    layers: list[str] = field(default_factory=list)
    face_layers: list[tuple[TopoDS_Shape, str]] = field(default_factory=list)


@dataclass
class Node:
    """Of the assembly tree, parents before children. part: -1 for an assembly. color: of the instance."""

    name: str
    parent: int
    part: int
    placement: tuple[float, ...]  # 12 numbers, rows, to the parent
    color: Color = NO_COLOR


Issue = tuple[int, str]  # (face number, or -1, reason)


@dataclass
class Writable:
    """A model in OpenCascade. unit: the file's, by our name. issues: what could not be said."""

    document: TDocStd_Document
    world: TopoDS_Shape  # all instances in their places
    unit: str = "mm"
    issues: list[Issue] = field(default_factory=list)


def writable(
    meta: dict[str, Any],
    parts: Sequence[Part],
    prototypes: Any,
    placements: Any,
    colors: Any,
    issues: Sequence[Issue] = (),
) -> Writable:
    """A model of parts, with tree, names and unit as its meta has them.

    prototypes (n,), placements (n, 12), colors (n, 4): of the instances. issues: known already.
    """
    document = new_document()
    filled = DocumentBuilder(document, parts, nodes_of(meta, prototypes, placements, colors))
    world = compound_of(
        [
            parts[part].shape.Moved(location_of(rows.reshape(3, 4)), False)
            for part, rows in zip(prototypes.tolist(), placements, strict=True)
        ]
    )
    unit = str(meta.get("unit", "mm"))
    return Writable(document, world, unit, [*issues, *((-1, text) for text in filled.issues)])


def nodes_of(meta: dict[str, Any], parts: Any, placements: Any, colors: Any) -> list[Node]:
    """The tree that a model's meta tells of; where it tells of none, all instances at the root.

    parts (n,), placements (n, 12), colors (n, 4): of the instances.
    """
    if not meta.get("tree"):
        return [
            Node("", -1, int(part), tuple(rows), color)
            for part, rows, color in zip(parts, placements.tolist(), colors.tolist(), strict=True)
        ]
    leaves = {
        int(about["node"]): (int(part), color)
        for about, part, color in zip(meta.get("instances", ()), parts, colors.tolist(), strict=True)
    }
    return [
        Node(
            str(n["name"]),
            int(n["parent"]),
            part,
            tuple(n["placement"]),
            color,
        )
        for i, n in enumerate(meta["tree"])
        for part, color in [leaves.get(i, (-1, NO_COLOR))]
    ]


class DocumentBuilder:
    """Fills a document; ``issues`` says what such documents cannot hold."""

    def __init__(self, document: TDocStd_Document, parts: Sequence[Part], nodes: Sequence[Node]) -> None:
        self.issues: list[str] = []
        self._parts, self._nodes = parts, nodes
        self._shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self._colors = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self._layers = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
        self._labels: dict[int, TDF_Label] = {}  # of parts
        self._assemblies: dict[Any, TDF_Label] = {}
        self._children: dict[int, list[int]] = {}
        for i, node in enumerate(nodes):
            self._children.setdefault(node.parent, []).append(i)
        self._keys: dict[int, Any] = {}
        for root in self._children.get(-1, []):
            self._add_root(root)
        self._shapes.UpdateAssemblies()

    def _add_root(self, index: int) -> None:
        node = self._nodes[index]
        place = self._location(node)
        if node.part < 0:
            self._assembly(index)
            if not place.IsIdentity():
                self.issues.append(f"{node.name}: an assembly at the root has a place of its own")
            return
        alone = sum(n.part == node.part for n in self._nodes) == 1
        if alone and node.color[0] < 0.0 and place.IsIdentity():
            self._part(node.part, node.name)
            return
        # A placed, coloured or repeated instance is a component: it needs an assembly to be one of.
        holder = self._shapes.NewShape()
        set_name(holder, node.name)
        self._add_component(holder, index)

    def _assembly(self, index: int) -> TDF_Label:
        """The assembly of a node; alike ones are one, as files mostly had them."""
        key = self._key(index)
        if key not in self._assemblies:
            label = self._assemblies[key] = self._shapes.NewShape()
            set_name(label, self._nodes[index].name)
            for child in self._children.get(index, []):
                self._add_component(label, child)
        return self._assemblies[key]

    def _key(self, index: int) -> Any:
        """What the node holds, by value."""
        if index not in self._keys:
            node = self._nodes[index]
            below = tuple((self._key(c), self._nodes[c].placement) for c in self._children.get(index, []))
            self._keys[index] = (node.name, node.part, tuple(node.color), below)
        return self._keys[index]

    def _add_component(self, assembly: TDF_Label, index: int) -> None:
        node = self._nodes[index]
        target = self._part(node.part, node.name) if node.part >= 0 else self._assembly(index)
        component = self._shapes.AddComponent(assembly, target, self._location(node))
        set_name(component, node.name)
        if node.color[0] >= 0.0:
            self._colors.SetColor(component, _rgba(node.color), _SURFACE)

    def _part(self, number: int, name: str) -> TDF_Label:
        """name: for a part without one."""
        if number in self._labels:
            return self._labels[number]
        part = self._parts[number]
        label = self._labels[number] = self._shapes.AddShape(part.shape, False)
        set_name(label, part.name or name)
        if part.color[0] >= 0.0:
            self._colors.SetColor(label, _rgba(part.color), _SURFACE)
        for layer in part.layers:
            self._layers.SetLayer(label, TCollection_ExtendedString(layer, True))
        for face, layer in part.face_layers:
            sub = self._shapes.AddSubShape(label, face)
            if not sub.IsNull():
                self._layers.SetLayer(sub, TCollection_ExtendedString(layer, True))
        for face, color, face_name in part.faces:
            sub = self._shapes.AddSubShape(label, face)
            if sub.IsNull():
                continue
            if color[0] >= 0.0:
                self._colors.SetColor(sub, _rgba(color), _SURFACE)
            set_name(sub, face_name)
        return label

    def _location(self, node: Node) -> TopLoc_Location:
        rows = np.array(node.placement, dtype=np.float64).reshape(3, 4)
        linear = rows[:, :3]
        if np.abs(linear @ linear.T - np.eye(3)).max() > _RIGID or np.linalg.det(linear) < 0.0:
            self.issues.append(f"{node.name}: mirrored or scaled, which a placement in the file cannot be")
        return location_of(rows)


def location_of(rows: Any) -> TopLoc_Location:
    """rows: (3, 4), rigid."""
    if np.array_equal(rows, np.eye(3, 4)):
        return TopLoc_Location()
    transform = gp_Trsf()
    transform.SetValues(*np.ascontiguousarray(rows).ravel().tolist())
    return TopLoc_Location(transform)


def _rgba(color: Color) -> Quantity_ColorRGBA:
    r, g, b, alpha = color
    return Quantity_ColorRGBA(Quantity_Color(r, g, b, Quantity_TypeOfColor.Quantity_TOC_sRGB), alpha)


def set_name(label: TDF_Label, name: str) -> None:
    """Nothing for an empty name."""
    if name:
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
