"""OpenCascade's own check of shapes (BRepCheck), in plain words and with our face numbers."""

from OCP.BRepCheck import BRepCheck_Analyzer, BRepCheck_Result, BRepCheck_Status
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from .inspect_shape import Walk
from .inspection import Fault

_WORDS = {
    "InvalidPointOnCurve": "a vertex does not lie on the edge's curve",
    "InvalidPointOnCurveOnSurface": "a vertex does not lie on the edge's curve on the face",
    "InvalidPointOnSurface": "a vertex does not lie on the face",
    "No3DCurve": "the edge has no curve in space",
    "Multiple3DCurve": "the edge has several curves in space",
    "Invalid3DCurve": "the edge's curve in space is invalid",
    "NoCurveOnSurface": "the edge has no curve on the face",
    "InvalidCurveOnSurface": "the edge's curve on the face is farther from the edge than its tolerance says",
    "InvalidCurveOnClosedSurface": "the seam's curves are farther from it than its tolerance says",
    "InvalidSameRangeFlag": "the edge and its curve on the face have different ranges",
    "InvalidSameParameterFlag": "the edge and its curve on the face run at different parameters",
    "InvalidDegeneratedFlag": "the edge is said to be a point, and is none",
    "FreeEdge": "only one face uses the edge",
    "InvalidMultiConnexity": "more than two faces use the edge",
    "InvalidRange": "the edge's range is empty or beyond its curve",
    "EmptyWire": "a loop has no edges",
    "RedundantEdge": "a loop uses an edge more often than it may",
    "SelfIntersectingWire": "a loop crosses itself",
    "NoSurface": "the face has no surface",
    "InvalidWire": "a loop is invalid",
    "RedundantWire": "a loop stands twice",
    "IntersectingWires": "two loops cross each other",
    "InvalidImbricationOfWires": "the loops do not lie inside each other as they should",
    "EmptyShell": "the shell has no faces",
    "RedundantFace": "the shell uses a face twice",
    "InvalidImbricationOfShells": "the shells do not lie inside each other as they should",
    "UnorientableShape": "its parts cannot be oriented alike",
    "NotClosed": "it is not closed",
    "NotConnected": "its parts do not hang together",
    "SubshapeNotInShape": "a part of it does not belong to it",
    "BadOrientation": "it is oriented the wrong way",
    "BadOrientationOfSubshape": "a part of it is oriented the wrong way",
    "InvalidPolygonOnTriangulation": "an edge's polygon on the triangulation is invalid",
    "InvalidToleranceValue": "its tolerance is invalid",
    "EnclosedRegion": "a region is enclosed that belongs to no solid",
    "CheckFail": "the check failed",
}  # fmt: skip
_KINDS = (
    ("vertex", TopAbs_ShapeEnum.TopAbs_VERTEX),
    ("edge", TopAbs_ShapeEnum.TopAbs_EDGE),
    ("loop", TopAbs_ShapeEnum.TopAbs_WIRE),
    ("face", TopAbs_ShapeEnum.TopAbs_FACE),
    ("shell", TopAbs_ShapeEnum.TopAbs_SHELL),
    ("solid", TopAbs_ShapeEnum.TopAbs_SOLID),
)


def check(walk: Walk, prototype: int) -> list[Fault]:
    """Whatever OpenCascade finds invalid in a prototype, each finding once."""
    try:
        analyzer = BRepCheck_Analyzer(walk.shape)
        if analyzer.IsValid():
            return []
    except Exception as error:  # whatever OpenCascade throws at a broken shape
        reason = " ".join(str(error).split())[:120]
        return [Fault("not checked", f"OpenCascade's check failed: {reason}", prototype)]
    return _Findings(walk, prototype, analyzer).faults


class _Findings:
    def __init__(self, walk: Walk, prototype: int, analyzer: BRepCheck_Analyzer) -> None:
        self.walk, self.prototype = walk, prototype
        self.faults: list[Fault] = []
        self._numbers: dict[TopoDS_Shape, list[int]] = {}
        self._kinds = {use.number: use.kind for use in walk.faces}
        self._edges: dict[TopoDS_Shape, int] = {}
        for use in walk.faces:
            self._numbers.setdefault(use.face.TShape(), []).append(use.number)
        for index, edge in enumerate(walk.edges):
            self._edges.setdefault(edge.TShape(), index)
        self._users = _users(walk)
        for word, kind in _KINDS:
            shapes = TopTools_IndexedMapOfShape()
            TopExp.MapShapes_s(walk.shape, kind, shapes)
            for shape in shapes:
                result = analyzer.Result(shape)
                if result is not None:
                    self._read(word, shape, result)

    def _read(self, word: str, shape: TopoDS_Shape, result: BRepCheck_Result) -> None:
        for status in result.Status():
            self._add(word, shape, status, None)
        result.InitContextIterator()
        while result.MoreShapeInContext():
            for status in result.StatusOnShape():
                self._add(word, shape, status, result.ContextualShape())
            result.NextShapeInContext()

    def _add(
        self, word: str, shape: TopoDS_Shape, status: BRepCheck_Status, context: TopoDS_Shape | None
    ) -> None:
        name = status.name.removeprefix("BRepCheck_")
        if name == "NoError" or self._is_mesh(shape):
            return
        faces = self._faces(shape) or (self._faces(context) if context is not None else ())
        if context is not None and context.ShapeType() == TopAbs_ShapeEnum.TopAbs_FACE:
            faces = self._faces(context) or faces
        what = f"{word}: {_WORDS.get(name, name)}"
        fault = Fault("invalid", what, self.prototype, faces, self._edges.get(shape.TShape(), -1))
        if fault not in self.faults[-64:]:
            self.faults.append(fault)

    def _is_mesh(self, shape: TopoDS_Shape) -> bool:
        """Faces that are triangles alone have no surface and no edges to be checked."""
        return any(self._kinds.get(number) == "mesh" for number in self._faces_in(shape))

    def _faces_in(self, shape: TopoDS_Shape) -> list[int]:
        faces = TopTools_IndexedMapOfShape()
        TopExp.MapShapes_s(shape, TopAbs_ShapeEnum.TopAbs_FACE, faces)
        return [number for face in faces for number in self._numbers.get(face.TShape(), [])]

    def _faces(self, shape: TopoDS_Shape) -> tuple[int, ...]:
        known = self._numbers.get(shape.TShape()) or self._users.get(shape.TShape(), [])
        return tuple(sorted(set(known)))


def _users(walk: Walk) -> dict[TopoDS_Shape, list[int]]:
    """Numbers of the faces that use an edge, a loop or a vertex."""
    users: dict[TopoDS_Shape, list[int]] = {}
    for use in walk.faces:
        for kind in (
            TopAbs_ShapeEnum.TopAbs_WIRE, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_VERTEX,
        ):  # fmt: skip
            shapes = TopTools_IndexedMapOfShape()
            TopExp.MapShapes_s(use.face, kind, shapes)
            for shape in shapes:
                users.setdefault(shape.TShape(), []).append(use.number)
    return users
