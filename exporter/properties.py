"""Validation properties of the parts of a document: volume, area and centroid, which STEP files can hold."""

from __future__ import annotations

from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Pnt
from OCP.GProp import GProp_GProps
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

_PRECISION = 1e-9  # relative, of the integration


def add_properties(document: TDocStd_Document) -> None:
    """Of every part that is made of solids; a volume means nothing for others."""
    labels = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetShapes(labels)
    for label in labels:
        shape = XCAFDoc_ShapeTool.GetShape_s(label)
        if not XCAFDoc_ShapeTool.IsSimpleShape_s(label) or not _only_solids(shape):
            continue
        volume, area = GProp_GProps(), GProp_GProps()
        BRepGProp.VolumeProperties_s(shape, volume, _PRECISION, False, False)
        BRepGProp.SurfaceProperties_s(shape, area, _PRECISION, False)
        XCAFDoc_Volume.Set_s(label, volume.Mass())
        XCAFDoc_Area.Set_s(label, area.Mass())
        centre = volume.CentreOfMass()
        XCAFDoc_Centroid.Set_s(label, gp_Pnt(centre.X(), centre.Y(), centre.Z()))


def _only_solids(shape: TopoDS_Shape) -> bool:
    solid, face = TopAbs_ShapeEnum.TopAbs_SOLID, TopAbs_ShapeEnum.TopAbs_FACE
    if not TopExp_Explorer(shape, solid).More():
        return False
    return not TopExp_Explorer(shape, face, solid).More()
