"""Joins faces along edges that are plainly the same curve, drawn twice: the quick part of sewing.

OpenCascade's sewing fits every edge that it joins anew, which takes seconds for thousands of edges. Here two
edges, each used by one face, become one when their curves agree: the first keeps its curve in space, and both
keep their curves on their surfaces. What does not agree so plainly is left to sewing.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepLib import BRepLib
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Shape, TopoDS_Vertex

from .edge_map import EdgeMap, Points, SpaceCurve, children

_SAMPLES = 9  # of a curve, ends included
_SHORTEST = 3.0  # tolerances; shorter edges match whatever is near


@dataclass
class _Pair:
    """Two edges that match, as indices into EdgeMap.edges."""

    kept: int
    gone: int
    turned: bool  # they run against each other
    distance: float  # the largest, mm


def join_matching_edges(faces: list[TopoDS_Shape], tolerance: float) -> list[TopoDS_Shape]:
    """The faces in the same order, matching edges shared; faces that share nothing new stay the very same.

    tolerance: mm, how far the curves of two edges may lie apart.
    """
    joiner = _Joiner(EdgeMap(faces))
    pairs = joiner.pairs(tolerance)
    return joiner.joined(pairs) if pairs else faces


class _Joiner:
    def __init__(self, shapes: EdgeMap) -> None:
        self.shapes = shapes
        self.vertices = shapes.vertices
        self.builder = shapes.builder

    def pairs(self, tolerance: float) -> list[_Pair]:
        """Edges of different faces that match each other and nothing else."""
        samples = self._samples(_SHORTEST * tolerance)
        users = self.shapes.users
        matches: dict[int, list[_Pair]] = defaultdict(list)
        for a, b in _near({edge: (p[0] + p[-1]) / 2 for edge, p in samples.items()}, tolerance):
            if users[a] == users[b]:
                continue
            for turned in (False, True):
                other = samples[b][::-1] if turned else samples[b]
                distance = self._distance(samples[a], other, b, turned, tolerance)
                if distance <= tolerance:
                    pair = _Pair(a, b, turned, distance)
                    matches[a].append(pair)
                    matches[b].append(pair)
                    break
        return [
            found[0]
            for edge, found in matches.items()
            if len(found) == 1 and found[0].kept == edge and len(matches[found[0].gone]) == 1
        ]

    def _samples(self, shortest: float) -> dict[int, Points]:
        """Points along every free edge, by equal steps of its parameter."""
        samples = {}
        for index in self.shapes.free_edges():
            points = SpaceCurve(self.shapes.edge(index)).even(_SAMPLES)
            if np.isfinite(points).all() and np.linalg.norm(np.diff(points, axis=0), axis=1).sum() > shortest:
                samples[index] = points
        return samples

    def _distance(self, one: Points, other: Points, edge: int, turned: bool, tolerance: float) -> float:
        """How far points of one edge lie off the other, whose points run the same way."""
        gaps = np.linalg.norm(one - other, axis=1)
        if gaps[0] > tolerance or gaps[-1] > tolerance:
            return float("inf")
        worst = float(gaps.max())
        if worst <= tolerance:
            return worst
        # The same curve at another pace?
        curve = SpaceCurve(self.shapes.edge(edge))
        worst = float(max(gaps[0], gaps[-1]))
        for k in range(1, _SAMPLES - 1):
            nearest = int(np.linalg.norm(other - one[k], axis=1).argmin())
            part = (nearest if not turned else _SAMPLES - 1 - nearest) / (_SAMPLES - 1)
            start = curve.first + part * (curve.last - curve.first)
            worst = max(worst, curve.nearest(one[k], start)[1])
            if worst > tolerance:
                return float("inf")
        return worst

    def joined(self, pairs: list[_Pair]) -> list[TopoDS_Shape]:
        vertices = self._join_vertices(pairs)
        edges: dict[
            int, tuple[list[TopoDS_Edge], bool]
        ] = {}  # what stands for an edge, and whether it is turned
        for pair in pairs:
            edge = self._join_edges(pair, vertices)
            edges[pair.kept] = [edge], False
            edges[pair.gone] = [edge], pair.turned
        for index in self.shapes.users:
            old = self.shapes.edge(index)
            if index not in edges and any(self.vertices.FindIndex(v) in vertices for v in children(old)):
                edges[index] = [self._copy(old, vertices)], False
        return self.shapes.replaced(edges)

    def _join_vertices(self, pairs: list[_Pair]) -> dict[int, TopoDS_Vertex]:
        """The new vertex for every vertex that becomes one with others."""
        leader: dict[int, int] = {}

        def find(vertex: int) -> int:
            while (up := leader.setdefault(vertex, vertex)) != vertex:
                vertex = up
            return vertex

        for pair in pairs:
            kept, gone = (
                (self.vertices.FindIndex(first), self.vertices.FindIndex(last))
                for edge in (pair.kept, pair.gone)
                for first, last in [_first_last(self.shapes.edge(edge))]
            )
            for one, other in zip(kept, gone[::-1] if pair.turned else gone, strict=True):
                a, b = find(one), find(other)
                leader[max(a, b)] = min(a, b)
        groups: dict[int, list[int]] = defaultdict(list)
        for vertex in list(leader):
            groups[find(vertex)].append(vertex)
        return {
            member: new
            for members in groups.values()
            if len(members) > 1
            for new in [self._one_vertex(members)]
            for member in members
        }

    def _one_vertex(self, members: list[int]) -> TopoDS_Vertex:
        olds = [TopoDS.Vertex_s(self.vertices.FindKey(member)) for member in members]
        point = BRep_Tool.Pnt_s(olds[0])
        reach = max(point.Distance(BRep_Tool.Pnt_s(old)) + BRep_Tool.Tolerance_s(old) for old in olds)
        vertex = TopoDS_Vertex()
        self.builder.MakeVertex(vertex, point, reach)
        return vertex

    def _copy(self, edge: TopoDS_Edge, vertices: dict[int, TopoDS_Vertex]) -> TopoDS_Edge:
        """An edge with the same curves between the new vertices. edge: forward."""
        copy = TopoDS.Edge_s(edge.EmptyCopied())
        for child in children(edge):
            vertex = vertices.get(self.vertices.FindIndex(child))
            self.builder.Add(copy, child if vertex is None else vertex.Oriented(child.Orientation()))
        return copy

    def _join_edges(self, pair: _Pair, vertices: dict[int, TopoDS_Vertex]) -> TopoDS_Edge:
        kept = self.shapes.edge(pair.kept)
        gone = self.shapes.edge(pair.gone)
        face = self.shapes.faces[self.shapes.users[pair.gone][0]]
        edge = self._copy(kept, vertices)
        tolerance = max(BRep_Tool.Tolerance_s(kept), BRep_Tool.Tolerance_s(gone) + pair.distance)
        curve = BRep_Tool.CurveOnSurface_s(gone, face, 0.0, 0.0)
        if curve is not None:
            first, last = BRep_Tool.Range_s(gone, face)
            if pair.turned:
                first, last = curve.ReversedParameter(last), curve.ReversedParameter(first)
                curve = curve.Reversed()
            location = TopLoc_Location()
            surface = BRep_Tool.Surface_s(face, location)
            self.builder.UpdateEdge(edge, curve, surface, location, tolerance)
            self.builder.Range(edge, surface, location, first, last)
            BRepLib.SameRange_s(edge)
        self.builder.UpdateEdge(edge, tolerance)
        return edge


def _first_last(edge: TopoDS_Edge) -> tuple[TopoDS_Vertex, TopoDS_Vertex]:
    return TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)


def _near(points: dict[int, Points], tolerance: float) -> Iterator[tuple[int, int]]:
    """All pairs of points, by their keys, that may lie within tolerance; the smaller key first."""
    cells: dict[tuple[int, int, int], list[int]] = defaultdict(list)
    steps = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
    for key, point in sorted(points.items(), key=lambda entry: entry[0]):
        x, y, z = np.floor(point / (2.0 * tolerance)).astype(np.int64).tolist()
        for i, j, k in steps:
            for other in cells.get((x + i, y + j, z + k), ()):
                yield other, key
        cells[x, y, z].append(key)
