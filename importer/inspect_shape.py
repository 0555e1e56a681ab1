"""The faces, edges and shells of one prototype, numbered as the store numbers them; counts of them."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Iterator, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from .inspection import Topology

_REVERSED = TopAbs_Orientation.TopAbs_REVERSED
_BOUNDS = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)
_FACE, _EDGE, _WIRE = TopAbs_ShapeEnum.TopAbs_FACE, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_WIRE
_SHELL, _SOLID = TopAbs_ShapeEnum.TopAbs_SHELL, TopAbs_ShapeEnum.TopAbs_SOLID
_VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX

# In the order of GeomAbs_SurfaceType and GeomAbs_CurveType.
_SURFACES = (
    "plane", "cylinder", "cone", "sphere", "torus", "bezier", "bspline", "revolution", "extrusion", "offset",
    "other",
)  # fmt: skip
_CURVES = ("line", "circle", "ellipse", "hyperbola", "parabola", "bezier", "bspline", "offset", "other")


@dataclass
class FaceUse:
    number: int  # of Model.faces
    face: TopoDS_Face
    shell: int  # index into Walk.shells, -1: in none
    kind: str
    loops: int = 0


@dataclass
class CoEdge:
    """One use of an edge by a face. edge: index into Walk.edges. oriented: the edge as the face turns it."""

    edge: int
    use: FaceUse
    reversed: bool
    oriented: TopoDS_Edge


@dataclass
class ShellUse:
    shell: TopoDS_Shape
    solid: int  # -1: of none
    faces: list[FaceUse] = field(default_factory=list)
    closed: bool = False


@dataclass
class Walk:
    """All of one prototype, in the order in which a depth-first walk meets it."""

    shape: TopoDS_Shape
    faces: list[FaceUse] = field(default_factory=list)
    shells: list[ShellUse] = field(default_factory=list)
    edges: list[TopoDS_Edge] = field(default_factory=list)
    coedges: list[list[CoEdge]] = field(default_factory=list)  # by edge
    degenerate: list[bool] = field(default_factory=list)  # by edge
    solids: int = 0
    vertices: int = 0


def walk_prototype(shape: TopoDS_Shape, first_face: int) -> Walk:
    """first_face: the number of its first face."""
    walk = Walk(shape)
    _visit(walk, shape, -1, -1, first_face)
    edges, vertices = TopTools_IndexedMapOfShape(), TopTools_IndexedMapOfShape()
    for use in walk.faces:
        for wire in _children(use.face, _WIRE):
            use.loops += 1
            for child in _children(wire, _EDGE):
                _add_use(walk, use, TopoDS.Edge_s(child), edges, vertices)
    walk.vertices = vertices.Extent()
    _find_closed(walk)
    return walk


def _visit(walk: Walk, shape: TopoDS_Shape, shell: int, solid: int, first_face: int) -> None:
    kind = shape.ShapeType()
    if kind == _FACE:
        face = TopoDS.Face_s(shape)
        walk.faces.append(FaceUse(first_face + len(walk.faces), face, shell, surface_kind(face)))
        if shell >= 0:
            walk.shells[shell].faces.append(walk.faces[-1])
        return
    if kind in (_WIRE, _EDGE, _VERTEX):
        return
    if kind == _SOLID:
        solid = walk.solids
        walk.solids += 1
    if kind == _SHELL:
        shell = len(walk.shells)
        walk.shells.append(ShellUse(shape, solid))
    iterator = TopoDS_Iterator(shape)
    while iterator.More():
        _visit(walk, iterator.Value(), shell, solid, first_face)
        iterator.Next()


def _children(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> Iterator[TopoDS_Shape]:
    """Of that kind, and part of a border."""
    iterator = TopoDS_Iterator(shape)
    while iterator.More():
        child = iterator.Value()
        if child.ShapeType() == kind and child.Orientation() in _BOUNDS:
            yield child
        iterator.Next()


def _add_use(
    walk: Walk,
    use: FaceUse,
    edge: TopoDS_Edge,
    edges: TopTools_IndexedMapOfShape,
    vertices: TopTools_IndexedMapOfShape,
) -> None:
    known = edges.Extent()
    index = edges.Add(edge) - 1
    if index == known:
        walk.edges.append(edge)
        walk.coedges.append([])
        walk.degenerate.append(BRep_Tool.Degenerated_s(edge))
        for vertex in _children(edge, _VERTEX):
            vertices.Add(vertex)
    walk.coedges[index].append(CoEdge(index, use, edge.Orientation() == _REVERSED, edge))


def _find_closed(walk: Walk) -> None:
    """A shell is closed when its faces use every edge as often one way as the other."""
    balance: list[Counter[int]] = [Counter() for _ in walk.shells]
    for index, uses in enumerate(walk.coedges):
        if walk.degenerate[index]:
            continue
        for coedge in uses:
            if coedge.use.shell >= 0:
                balance[coedge.use.shell][index] += -1 if coedge.reversed else 1
    for shell, uses_of in zip(walk.shells, balance, strict=True):
        shell.closed = bool(shell.faces) and not any(uses_of.values()) and _bounded(shell)


def _bounded(shell: ShellUse) -> bool:
    return all(use.loops > 0 or use.kind in ("sphere", "torus") for use in shell.faces)


def counts(walk: Walk, inside_out: int) -> Topology:
    """inside_out: shells, which only their volumes tell."""
    seams = free = nonmanifold = 0
    for index in range(len(walk.edges)):
        kind = edge_role(walk, index)
        seams += kind == "seam"
        free += kind == "free"
        nonmanifold += kind == "non-manifold"
    kinds = Counter(
        curve_kind(edge) for edge, pole in zip(walk.edges, walk.degenerate, strict=True) if not pole
    )
    return Topology(
        solids=walk.solids,
        shells=len(walk.shells),
        closed_shells=sum(shell.closed for shell in walk.shells),
        faces=len(walk.faces),
        loops=sum(use.loops for use in walk.faces),
        edges=len(walk.edges),
        vertices=walk.vertices,
        seam_edges=seams,
        degenerate_edges=sum(walk.degenerate),
        free_edges=free,
        nonmanifold_edges=nonmanifold,
        lone_faces=sum(use.shell < 0 for use in walk.faces),
        inside_out_shells=inside_out,
        faces_by_kind=dict(sorted(Counter(use.kind for use in walk.faces).items())),
        edges_by_kind=dict(sorted(kinds.items())),
    )


def edge_role(walk: Walk, index: int) -> str:
    """ "degenerate", "free", "seam", "non-manifold", or "" for what two faces share in opposite directions.

    Faces of different shells may meet in one edge: each shell is judged alone, faces in no shell together.
    """
    if walk.degenerate[index]:
        return "degenerate"
    shells: dict[int, list[CoEdge]] = {}
    for coedge in walk.coedges[index]:
        shells.setdefault(coedge.use.shell, []).append(coedge)
    role = ""
    for uses in shells.values():
        if len(uses) == 1:
            role = role or "free"
        elif len(uses) > 2 or uses[0].reversed == uses[1].reversed:
            return "non-manifold"
        elif uses[0].use is uses[1].use:
            role = role or "seam"
    return role


def surface_kind(face: TopoDS_Face) -> str:
    surface = BRep_Tool.Surface_s(face, TopLoc_Location())
    if surface is None:
        return "mesh"
    return _SURFACES[int(GeomAdaptor_Surface(surface).GetType().value)]


def curve_kind(edge: TopoDS_Edge) -> str:
    """Of the edge's curve in space, "none" where it has none."""
    if BRep_Tool.Curve_s(edge, 0.0, 0.0) is None:
        return "none"
    return _CURVES[int(BRepAdaptor_Curve(edge).GetType().value)]


def has_surface(face: TopoDS_Face) -> bool:
    return BRep_Tool.Surface_s(face, TopLoc_Location()) is not None
