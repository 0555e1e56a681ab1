"""What the exporter's tests measure of shapes."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from OCP.BinTools import BinTools_ShapeSet
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Face, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from trimray.exporter.topology import PrototypeBuilder
from trimray.importer import BrepModel

KINDS = ("COMPSOLID", "SOLID", "SHELL", "FACE", "WIRE", "EDGE", "VERTEX")


def sources_of(model: BrepModel) -> list[TopoDS_Shape]:
    """The prototypes as OpenCascade read them."""
    shapes = BinTools_ShapeSet()
    shapes.Read(io.BytesIO(model.brep))
    return [shapes.Shape(int(i)) for i in model.prototype_shapes]


def counts(shape: TopoDS_Shape) -> dict[str, int]:
    """Distinct shapes by kind."""
    found = {}
    for kind in KINDS[1:]:
        shapes = TopTools_IndexedMapOfShape()
        TopExp.MapShapes_s(shape, getattr(TopAbs_ShapeEnum, f"TopAbs_{kind}"), shapes)
        found[kind] = shapes.Extent()
    return found


def faces(shape: TopoDS_Shape) -> list[TopoDS_Face]:
    """In the order of the store's face numbers."""
    found = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    while explorer.More():
        found.append(TopoDS.Face_s(explorer.Current()))
        explorer.Next()
    return found


def volume_and_area(shape: TopoDS_Shape) -> tuple[float, float]:
    """Integrated until halving changes them by less than 1e-10: the plain rule takes as many points as the
    surface has knots, and says other figures for the same surface with other knots."""
    volume, area = GProp_GProps(), GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, volume, 1e-10, False, False)
    BRepGProp.SurfaceProperties_s(shape, area, 1e-10, False)
    return volume.Mass(), area.Mass()


def plain_area(shape: TopoDS_Shape) -> float:
    """By the plain rule: of surfaces with the same knots."""
    area = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, area)
    return area.Mass()


def is_valid(shape: TopoDS_Shape) -> bool:
    return bool(BRepCheck_Analyzer(shape).IsValid())


def deviation(arrays: dict[str, Any], part: PrototypeBuilder, source: TopoDS_Shape, points: int) -> float:
    """Largest distance of the surfaces at the same seeded (u, v), in parts of the prototype's diagonal."""
    random = np.random.default_rng(7)
    size = float(np.linalg.norm(np.ptp(part.record["bounds"], axis=0)))
    first = int(part.record["faces"][0])
    worst = 0.0
    for number, original in enumerate(faces(source), start=first):
        if number not in part.faces:
            continue
        place = TopLoc_Location()
        expected = BRep_Tool.Surface_s(original, place)
        made = BRep_Tool.Surface_s(part.faces[number])
        if expected is None or made is None:
            continue
        if not place.IsIdentity():
            expected = expected.Transformed(place.Transformation())
        low, high = arrays["faces"][number]["uv_box"]
        for u, v in (low + random.random((points, 2)) * (high - low)).tolist():
            worst = max(worst, made.Value(u, v).Distance(expected.Value(u, v)))
    return worst / size if size > 0.0 else worst
