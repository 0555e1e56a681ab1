"""An edge in space, as inspections follow it."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Iterator

Array = npt.NDArray[np.float64]

# Steps towards the foot of a perpendicular.
_FOOT_STEPS = 5


class EdgePath:
    """An edge in space. resolution: mm, the noise of evaluating it."""

    def __init__(self, edge: TopoDS_Edge) -> None:
        self.curve = BRepAdaptor_Curve(edge)
        self.first, self.last = float(self.curve.FirstParameter()), float(self.curve.LastParameter())
        self.same_parameter = BRep_Tool.SameParameter_s(edge)
        start = self.point(self.first)
        apart = math.dist(start, self.point(self.last))
        self.closed = self.last > self.first and apart <= 2.0 * BRep_Tool.Tolerance_s(edge)
        self.resolution = 1e-12 * max(1.0, float(np.abs(start).max()))

    def point(self, t: float) -> tuple[float, ...]:
        return coordinates(self.curve.Value(t))

    def sample(self, at: Array) -> tuple[Array, Array]:
        """Points and derivatives by the parameter, (n, 3)."""
        point, along = gp_Pnt(), gp_Vec()
        points, tangents = [], []
        for t in at.tolist():
            self.curve.D1(t, point, along)
            points.append(point.Coord())
            tangents.append(along.Coord())
        return np.array(points), np.array(tangents)

    def length(self) -> float:
        return float(GCPnts_AbscissaPoint.Length_s(self.curve))

    def largest_distance(self, samples: Array, points: Array) -> float:
        """Of points from the curve, at whatever parameter: samples say where to look for them first. Each
        foot is searched by the Gauss-Newton method; a wrong one gives too much, never too little."""
        worst = 0.0
        near, along = gp_Pnt(), gp_Vec()
        for t, goal in zip(samples.tolist(), points, strict=True):
            best = math.inf
            for _ in range(_FOOT_STEPS):
                self.curve.D1(t, near, along)
                apart, tangent = goal - coordinates(near), np.array(coordinates(along))
                best = min(best, float(np.linalg.norm(apart)))
                speed = float(tangent @ tangent)
                if speed == 0.0:
                    break
                t = self._within(t + float(apart @ tangent) / speed)
            worst = max(worst, best)
        return worst

    def _within(self, t: float) -> float:
        """The nearest parameter of the edge; round a closed one."""
        if self.closed and math.isfinite(t):
            return self.first + (t - self.first) % (self.last - self.first)
        return min(max(t, self.first), self.last)


class PointPath(EdgePath):
    """A degenerate edge: its vertex is all there is of it."""

    def __init__(self, edge: TopoDS_Edge, vertex: tuple[float, ...]) -> None:
        self.vertex = vertex
        self.first, self.last = _range(edge)
        self.same_parameter = True
        self.resolution = 1e-12 * max(1.0, max(abs(x) for x in vertex))

    def point(self, t: float) -> tuple[float, ...]:
        return self.vertex

    def sample(self, at: Array) -> tuple[Array, Array]:
        return np.tile(np.array(self.vertex), (len(at), 1)), np.zeros((len(at), 3))

    def length(self) -> float:
        return 0.0


def path_of(edge: TopoDS_Edge, degenerate: bool) -> EdgePath | None:
    """None for an edge that has no curve in space, or one without end."""
    if degenerate:
        ends = vertices_of(edge)
        return PointPath(edge, coordinates(BRep_Tool.Pnt_s(ends[0][1]))) if ends else None
    if BRep_Tool.Curve_s(edge, 0.0, 0.0) is None:
        return None
    path = EdgePath(edge)
    return path if math.isfinite(path.first) and math.isfinite(path.last) else None


def _range(edge: TopoDS_Edge) -> tuple[float, float]:
    first, last = BRep_Tool.Range_s(edge)
    return float(first), float(last)


def vertices_of(edge: TopoDS_Edge) -> list[tuple[bool, object]]:
    """(at the end, vertex) of the edge's ends."""
    found = []
    iterator = TopoDS_Iterator(edge.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    while iterator.More():
        vertex = iterator.Value()
        if vertex.ShapeType() == TopAbs_ShapeEnum.TopAbs_VERTEX and vertex.Orientation() in (
            TopAbs_Orientation.TopAbs_FORWARD,
            TopAbs_Orientation.TopAbs_REVERSED,
        ):
            at_end = vertex.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
            found.append((at_end, TopoDS.Vertex_s(vertex)))
        iterator.Next()
    return found


def coordinates(triple: Any) -> tuple[float, float, float]:
    found: tuple[float, float, float] = triple.Coord()
    return found
