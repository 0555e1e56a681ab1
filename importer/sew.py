"""Sewing: faces that touch within tolerance come to share their edges. No face may be lost by it."""

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
from OCP.BRepLib import BRepLib
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Shape, TopoDS_Solid
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from .cut_edges import cut_edges
from .match_edges import join_matching_edges
from .occt import faces_of
from .report import Report
from .scene import Part

# Beyond so many free edges OpenCascade's sewing takes seconds, and most of them are joined before it.
_MANY_FREE_EDGES = 1000


def sew_part(part: Part, tolerance: float, report: Report) -> None:
    """Sews the faces of a part in place, colours and names kept; leaves it alone when a face would be lost.

    tolerance: mm. Parts whose edges are already shared are left alone.
    """
    faces = list(faces_of(part.shape))
    free_edges = _count_free_edges(part.shape)
    if len(faces) < 2 or free_edges == 0:
        return
    sewing = BRepBuilderAPI_Sewing(tolerance)
    try:
        prepared = faces
        if free_edges > _MANY_FREE_EDGES:
            prepared = join_matching_edges(cut_edges(faces, tolerance), tolerance)
        for face in prepared:
            sewing.Add(face)
        sewing.Perform()
        sewn = sewing.SewedShape()
    except Exception as error:  # whatever OpenCascade throws: the faces are good without it
        report.add("", "sewing", f"{part.name}: left unsewn: {type(error).__name__}: {error}", "warning")
        return
    images = [sewing.ModifiedSubShape(face) for face in prepared]
    arrived = faces_of(sewn)
    if arrived.Extent() != len(faces) or not all(arrived.Contains(image) for image in images):
        reason = f"sewing within {tolerance:g} mm would leave {arrived.Extent()} of {len(faces)} faces"
        report.add("", "sewing", f"{part.name}: left unsewn: {reason}", "warning")
        return
    image_of = {_key(face): image for face, image in zip(faces, images, strict=True)}
    part.face_colors = [(image_of.get(_key(face), face), color) for face, color in part.face_colors]
    part.face_names = [(image_of.get(_key(face), face), name) for face, name in part.face_names]
    part.shape = _turned_outward(sewn)


def _key(face: TopoDS_Shape) -> object:
    return face.TShape()


def _count_free_edges(shape: TopoDS_Shape) -> int:
    users = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, TopAbs_ShapeEnum.TopAbs_EDGE, TopAbs_ShapeEnum.TopAbs_FACE, users)
    return sum(
        users.FindFromIndex(index).Extent() == 1
        and not BRep_Tool.Degenerated_s(TopoDS.Edge_s(users.FindKey(index)))
        for index in range(1, users.Extent() + 1)
    )


def _turned_outward(shape: TopoDS_Shape) -> TopoDS_Shape:
    """Closed shells with their normals to the outside."""
    if shape.ShapeType() == TopAbs_ShapeEnum.TopAbs_SHELL and BRep_Tool.IsClosed_s(shape):
        builder = BRep_Builder()
        solid = TopoDS_Solid()
        builder.MakeSolid(solid)
        builder.Add(solid, shape)
        BRepLib.OrientClosedSolid_s(solid)
        return solid
    return shape
