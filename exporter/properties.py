"""Validation properties of the parts of a document: volume, area and centroid, which STEP files can hold."""

from __future__ import annotations

from OCP.gp import gp_Pnt
from OCP.TDF import TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import (
    XCAFDoc_Area,
    XCAFDoc_Centroid,
    XCAFDoc_DocumentTool,
    XCAFDoc_ShapeTool,
    XCAFDoc_Volume,
)

from ..importer.inspect_mass import measure_shape


def add_properties(document: TDocStd_Document) -> None:
    """Of every part that is made of solids; a volume means nothing for others. Parts that cannot be measured
    have none."""
    labels = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetShapes(labels)
    for label in labels:
        shape = XCAFDoc_ShapeTool.GetShape_s(label)
        if not XCAFDoc_ShapeTool.IsSimpleShape_s(label) or not _only_solids(shape):
            continue
        mass = measure_shape(shape)
        if mass.left_out or mass.centroid is None:
            continue
        XCAFDoc_Volume.Set_s(label, mass.volume)
        XCAFDoc_Area.Set_s(label, mass.area)
        XCAFDoc_Centroid.Set_s(label, gp_Pnt(*mass.centroid))


def _only_solids(shape: TopoDS_Shape) -> bool:
    solid, face = TopAbs_ShapeEnum.TopAbs_SOLID, TopAbs_ShapeEnum.TopAbs_FACE
    if not TopExp_Explorer(shape, solid).More():
        return False
    return not TopExp_Explorer(shape, face, solid).More()
