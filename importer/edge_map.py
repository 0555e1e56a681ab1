"""Faces taken apart into edges and vertices, and put together again with other edges."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

Points = NDArray[np.float64]  # (n, 3), mm
FORWARD = TopAbs_Orientation.TopAbs_FORWARD


class EdgeMap:
    """The edges and vertices of some faces by index, and who uses them."""

    def __init__(self, faces: list[TopoDS_Shape]) -> None:
        self.faces = [TopoDS.Face_s(face) for face in faces]
        self.edges = TopTools_IndexedMapOfShape()
        self.vertices = TopTools_IndexedMapOfShape()
        self.users: dict[int, list[int]] = defaultdict(list)  # faces of an edge, one for each use
        self.builder = BRep_Builder()
        for number, face in enumerate(self.faces):
            TopExp.MapShapes_s(face, TopAbs_ShapeEnum.TopAbs_VERTEX, self.vertices)
            explorer = TopExp_Explorer(face, TopAbs_ShapeEnum.TopAbs_EDGE)
            while explorer.More():
                self.users[self.edges.Add(explorer.Current())].append(number)
                explorer.Next()

    def edge(self, index: int) -> TopoDS_Edge:
        return TopoDS.Edge_s(self.edges.FindKey(index).Oriented(FORWARD))

    def free_edges(self) -> list[int]:
        """Edges that one face uses once, and that have a curve and two ends."""
        return [
            index
            for index, users in self.users.items()
            if len(users) == 1 and _has_curve(edge := self.edge(index)) and len(list(children(edge))) == 2
        ]

    def rebuilt(self, face: TopoDS_Face, edges: dict[int, tuple[list[TopoDS_Edge], bool]]) -> TopoDS_Shape:
        """The face with its edges replaced: by edges that follow each other, or by one that may be turned."""
        forward = face.Oriented(FORWARD)
        new_face = forward.EmptyCopied()
        for wire in children(forward):
            new_wire = wire.EmptyCopied().Oriented(FORWARD)
            for edge in children(wire.Oriented(FORWARD)):
                new, turned = edges.get(self.edges.FindIndex(edge), ([edge], False))
                for part in new if edge.Orientation() == FORWARD else new[::-1]:
                    use = part.Oriented(edge.Orientation())
                    self.builder.Add(new_wire, use.Reversed() if turned else use)
            new_wire.Closed(wire.Closed())
            self.builder.Add(new_face, new_wire.Oriented(wire.Orientation()))
        return new_face.Oriented(face.Orientation())

    def replaced(self, edges: dict[int, tuple[list[TopoDS_Edge], bool]]) -> list[TopoDS_Shape]:
        """All faces; those without a replaced edge stay the very same."""
        changed = {face for index in edges for face in self.users[index]}
        return [
            self.rebuilt(face, edges) if number in changed else face for number, face in enumerate(self.faces)
        ]


def children(shape: TopoDS_Shape) -> Iterator[TopoDS_Shape]:
    """Each with its own orientation in the shape and its place in the world."""
    iterator = TopoDS_Iterator(shape, False, True)
    while iterator.More():
        yield iterator.Value()
        iterator.Next()


class SpaceCurve:
    """The curve of an edge in space."""

    def __init__(self, edge: TopoDS_Edge) -> None:
        self._curve = BRepAdaptor_Curve(edge)
        self.first, self.last = self._curve.FirstParameter(), self._curve.LastParameter()

    def points(self, parameters: Points) -> Points:
        return np.array([(p.X(), p.Y(), p.Z()) for p in map(self._curve.Value, parameters.tolist())])

    def even(self, count: int) -> Points:
        """Points at equal steps of the parameter."""
        return self.points(np.linspace(self.first, self.last, count))

    def nearest(self, point: Points, start: float) -> tuple[float, float]:
        """Parameter and distance of the curve's point near one, by Newton iteration from a parameter."""
        x, y, z = point.tolist()
        at, along = gp_Pnt(), gp_Vec()
        t, enough = start, (self.last - self.first) * 1e-6
        for _ in range(8):
            self._curve.D1(t, at, along)
            slope = max(along.SquareMagnitude(), 1e-300)
            gap = (x - at.X()) * along.X() + (y - at.Y()) * along.Y() + (z - at.Z()) * along.Z()
            last, t = t, min(max(t + gap / slope, self.first), self.last)
            if abs(t - last) <= enough:
                break
        self._curve.D0(t, at)
        return t, at.Distance(gp_Pnt(x, y, z))


def _has_curve(edge: TopoDS_Edge) -> bool:
    if BRep_Tool.Degenerated_s(edge) or BRep_Tool.Curve_s(edge, TopLoc_Location(), 0.0, 0.0) is None:
        return False
    return bool(np.isfinite(BRep_Tool.Range_s(edge)).all())
