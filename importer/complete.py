"""What healing would have done and the tracer needs: p-curves and 3D curves; and the strict checks."""

from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.Precision import Precision
from OCP.ShapeFix import ShapeFix_Edge
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape

from .occt import faces_of
from .report import Report
from .scene import Scene


def add_missing_curves(scene: Scene, report: Report) -> None:
    """Adds the 3D curves and, on faces that are no planes, the p-curves that a file lacks."""
    for part in scene.parts:
        BRepLib.BuildCurves3d_s(part.shape)
        for number, shape in enumerate(faces_of(part.shape), start=1):
            face = TopoDS.Face_s(shape)
            surface = BRep_Tool.Surface_s(face, TopLoc_Location())
            if surface is None or GeomAdaptor_Surface(surface).GetType() == GeomAbs_SurfaceType.GeomAbs_Plane:
                continue
            missing = _add_pcurves(face)
            if missing:
                report.add(
                    f"face {number}", "FACE", f"{part.name}: {missing} edges have no curve on the surface"
                )


def _add_pcurves(face: TopoDS_Face) -> int:
    """How many edges of the face stay without a p-curve."""
    missing = 0
    fix = ShapeFix_Edge()
    edges = TopExp_Explorer(face, TopAbs_ShapeEnum.TopAbs_EDGE)
    while edges.More():
        edge = TopoDS.Edge_s(edges.Current())
        if BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0) is None:
            fix.FixAddPCurve(edge, face, BRep_Tool.IsClosed_s(edge, face), Precision.Confusion_s())
            if BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 0.0) is None:
                missing += 1
        edges.Next()
    return missing


def check_faces(scene: Scene, report: Report, precision: float | None) -> None:
    """heal="strict": reports every invalid face, and every face with an edge or vertex beyond tolerance."""
    bound = precision if precision is not None else 1e-3
    for part in scene.parts:
        analyzer = BRepCheck_Analyzer(part.shape)
        for number, face in enumerate(faces_of(part.shape), start=1):
            label = f"face {number}"
            if BRep_Tool.Surface_s(TopoDS.Face_s(face), TopLoc_Location()) is None:
                continue
            if not analyzer.IsValid(face):
                report.add(label, "FACE", f"{part.name}: invalid (BRepCheck)")
            worst = _worst_tolerance(face)
            if worst > bound:
                report.add(
                    label,
                    "FACE",
                    f"{part.name}: its edges fit within {worst:.3g} mm only, beyond {bound:g} mm",
                )


def _worst_tolerance(face: TopoDS_Shape) -> float:
    worst = 0.0
    edges = TopExp_Explorer(face, TopAbs_ShapeEnum.TopAbs_EDGE)
    while edges.More():
        worst = max(worst, BRep_Tool.Tolerance_s(TopoDS.Edge_s(edges.Current())))
        edges.Next()
    return worst
