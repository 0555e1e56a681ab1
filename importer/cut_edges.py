"""Cuts edges where the corner of a neighbour lies on them, so that both sides have the same pieces."""

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Shape, TopoDS_Vertex

from .edge_map import FORWARD, EdgeMap, Points, SpaceCurve, children

_SAMPLES = 33  # of a curve
_SHORTEST = 4.0  # tolerances, of a piece


def cut_edges(faces: list[TopoDS_Shape], tolerance: float) -> list[TopoDS_Shape]:
    """The faces in the same order. tolerance: mm, how far a vertex may lie off the edge that it cuts."""
    shapes = EdgeMap(faces)
    free = shapes.free_edges()
    corners = sorted({shapes.vertices.FindIndex(v) for index in free for v in children(shapes.edge(index))})
    vertices = [TopoDS.Vertex_s(shapes.vertices.FindKey(corner)) for corner in corners]
    places = np.array([_place(vertex) for vertex in vertices], np.float64).reshape(-1, 3)
    places = places[places[:, 0].argsort()]
    pieces: dict[int, tuple[list[TopoDS_Edge], bool]] = {}
    for index in free:
        edge = shapes.edge(index)
        face = shapes.faces[shapes.users[index][0]]
        if BRep_Tool.Range_s(edge) != BRep_Tool.Range_s(edge, face):
            continue
        cuts = _cuts(SpaceCurve(edge), places, tolerance)
        if cuts:
            pieces[index] = _cut(shapes, edge, cuts), False
    return shapes.replaced(pieces) if pieces else faces


def _place(vertex: TopoDS_Vertex) -> tuple[float, float, float]:
    point = BRep_Tool.Pnt_s(vertex)
    return point.X(), point.Y(), point.Z()


def _cuts(curve: SpaceCurve, corners: Points, tolerance: float) -> list[float]:
    """Parameters in order at which corners (sorted by x) lie on the inside of the curve."""
    points = curve.even(_SAMPLES)
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not np.isfinite(lengths).all() or not lengths.sum() > 2.0 * _SHORTEST * tolerance:
        return []
    bulge = tolerance + 0.25 * float(lengths.max())  # a smooth curve stays that near to its chords
    low, high = points.min(axis=0) - bulge, points.max(axis=0) + bulge
    corners = corners[
        np.searchsorted(corners[:, 0], low[0]) : np.searchsorted(corners[:, 0], high[0], "right")
    ]
    inside = (corners >= low) & (corners <= high)
    least = _SHORTEST * tolerance
    found: list[tuple[float, Points]] = []
    for corner in corners[inside.all(axis=1)]:
        if min(np.linalg.norm(corner - points[0]), np.linalg.norm(corner - points[-1])) <= least:
            continue
        along = ((corner - points[:-1]) * steps).sum(axis=1) / np.maximum(lengths**2, 1e-300)
        along = np.clip(along, 0.0, 1.0)
        gaps = np.linalg.norm(points[:-1] + along[:, None] * steps - corner, axis=1)
        best = int(gaps.argmin())
        if gaps[best] > bulge:
            continue
        start = curve.first + (curve.last - curve.first) * (best + float(along[best])) / (_SAMPLES - 1)
        parameter, gap = curve.nearest(corner, start)
        if gap <= tolerance:
            found.append((parameter, corner))
    found.sort(key=lambda entry: entry[0])
    cuts: list[float] = []
    last = points[0]
    for parameter, corner in found:
        if np.linalg.norm(corner - last) > least:
            cuts.append(parameter)
            last = corner
    return cuts


def _cut(shapes: EdgeMap, edge: TopoDS_Edge, cuts: list[float]) -> list[TopoDS_Edge]:
    """The pieces of an edge, in its own direction."""
    curve = SpaceCurve(edge)
    tolerance = BRep_Tool.Tolerance_s(edge)
    ends = [TopExp.FirstVertex_s(edge)]
    for x, y, z in curve.points(np.array(cuts)).tolist():
        vertex = TopoDS_Vertex()
        shapes.builder.MakeVertex(vertex, gp_Pnt(x, y, z), tolerance)
        ends.append(vertex)
    ends.append(TopExp.LastVertex_s(edge))
    bounds = [curve.first, *cuts, curve.last]
    pieces = []
    for k in range(len(bounds) - 1):
        piece = TopoDS.Edge_s(edge.EmptyCopied())
        shapes.builder.Add(piece, ends[k].Oriented(FORWARD))
        shapes.builder.Add(piece, ends[k + 1].Oriented(TopAbs_Orientation.TopAbs_REVERSED))
        shapes.builder.Range(piece, bounds[k], bounds[k + 1])
        pieces.append(piece)
    return pieces
