"""What the readers hand to extract.py: parts, the tree that places them, and their colours.

Colours here are RGBA as OpenCascade holds them: linear RGB, straight alpha. extract.py encodes them.
"""

from dataclasses import dataclass, field
from typing import Any

from OCP.gp import gp_Trsf
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape

Color = tuple[float, float, float, float]


@dataclass
class Part:
    """A prototype: a shape at the identity location, with what is known of its faces."""

    shape: TopoDS_Shape
    name: str = ""
    color: Color | None = None
    # Later entries win: a solid's colour stands before those of its faces.
    face_colors: list[tuple[TopoDS_Shape, Color]] = field(default_factory=list)
    face_names: list[tuple[TopoDS_Shape, str]] = field(default_factory=list)
    layers: tuple[str, ...] = ()
    face_layers: list[tuple[TopoDS_Shape, str]] = field(default_factory=list)


@dataclass
class Node:
    name: str
    parent: int  # index into Scene.nodes, -1 at a root
    part: int  # index into Scene.parts, -1 for an assembly
    local: TopLoc_Location


@dataclass
class Placed:
    """A part in the world."""

    node: int
    placement: TopLoc_Location
    color: Color | None = None
    layers: tuple[str, ...] = ()  # its own and those of the assemblies above it


@dataclass
class Scene:
    parts: list[Part] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    placed: list[Placed] = field(default_factory=list)
    products: int = 0  # distinct ones, assemblies included
    components: int = 0  # distinct uses of a product in an assembly
    session: Any = None  # XSControl_WorkSession of the reader, where there was one

    def add_node(self, name: str, parent: int, local: TopLoc_Location) -> int:
        """Index of a new assembly node; ``place`` turns a node into a leaf."""
        self.nodes.append(Node(name, parent, -1, local))
        return len(self.nodes) - 1

    def place(
        self,
        node: int,
        part: int,
        placement: TopLoc_Location,
        color: Color | None,
        layers: tuple[str, ...] = (),
    ) -> None:
        self.nodes[node].part = part
        self.placed.append(Placed(node, placement, color, layers))

    def path(self, node: int) -> tuple[str, ...]:
        """Names from the root to the node."""
        names = []
        while node >= 0:
            names.append(self.nodes[node].name)
            node = self.nodes[node].parent
        return tuple(reversed(names))


def matrix(location: TopLoc_Location) -> tuple[float, ...]:
    """Rows of the 3x4 matrix of a location, 12 numbers."""
    if location.IsIdentity():
        return (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    transform: gp_Trsf = location.Transformation()
    return tuple(transform.Value(row, column) for row in (1, 2, 3) for column in (1, 2, 3, 4))
