"""Files for tests, written by OpenCascade."""

import re
from pathlib import Path

from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.BRepTools import BRepTools
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Writer
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from trimray.importer import occt

SURFACE_COLOR = XCAFDoc_ColorType.XCAFDoc_ColorSurf
CURVE_COLOR = XCAFDoc_ColorType.XCAFDoc_ColorCurv


def box(x: float = 10.0, y: float = 20.0, z: float = 30.0) -> TopoDS_Shape:
    return BRepPrimAPI_MakeBox(x, y, z).Shape()


def cylinder(radius: float = 5.0, height: float = 12.0) -> TopoDS_Shape:
    return BRepPrimAPI_MakeCylinder(radius, height).Shape()


def faces(shape: TopoDS_Shape) -> list[TopoDS_Shape]:
    found = []
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def rgba(red: float, green: float, blue: float, alpha: float = 1.0) -> Quantity_ColorRGBA:
    """From sRGB-encoded values, as files give them."""
    color = Quantity_ColorRGBA(
        Quantity_Color(red, green, blue, Quantity_TypeOfColor.Quantity_TOC_sRGB), alpha
    )
    return color


def moved(x: float = 0.0, y: float = 0.0, z: float = 0.0, *, turn_z: float = 0.0) -> TopLoc_Location:
    """First turned about z (radians), then moved."""
    turn, move = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), turn_z)
    move.SetTranslation(gp_Vec(x, y, z))
    return TopLoc_Location(move.Multiplied(turn))


class Document:
    """A STEP file in the making."""

    def __init__(self) -> None:
        occt.initialize()
        self.document = occt.new_document()
        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        self.colors = XCAFDoc_DocumentTool.ColorTool_s(self.document.Main())

    def part(self, shape: TopoDS_Shape, name: str) -> TDF_Label:
        label = self.shapes.AddShape(shape, False)
        return self.named(label, name)

    def assembly(self, name: str) -> TDF_Label:
        return self.named(self.shapes.NewShape(), name)

    def component(
        self, assembly: TDF_Label, part: TDF_Label, location: TopLoc_Location, name: str
    ) -> TDF_Label:
        label = self.shapes.AddComponent(assembly, part, location)
        return self.named(label, name)

    def named(self, label: TDF_Label, name: str) -> TDF_Label:
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))
        return label

    def subshape(self, part: TDF_Label, shape: TopoDS_Shape) -> TDF_Label:
        return self.shapes.AddSubShape(part, shape)

    def color(
        self, label: TDF_Label, color: Quantity_ColorRGBA, kind: XCAFDoc_ColorType = SURFACE_COLOR
    ) -> None:
        self.colors.SetColor(label, color, kind)

    def color_occurrence(
        self, components: list[TDF_Label], part: TDF_Label, color: Quantity_ColorRGBA
    ) -> None:
        """components: from the top assembly down to the reference to the part."""
        place = TopLoc_Location()
        for component in components:
            place = place.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(component))
        shape = XCAFDoc_ShapeTool.GetShape_s(part).Moved(place)
        assert self.colors.SetInstanceColor(shape, SURFACE_COLOR, color)

    def write(self, path: Path, *, unit: str = "MM") -> Path:
        self.shapes.UpdateAssemblies()
        occt.initialize()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        Interface_Static.SetCVal_s(
            "write.step.schema", "AP214IS"
        )  # whatever was written before, in this process
        writer = STEPCAFControl_Writer()
        writer.SetColorMode(True)
        writer.SetNameMode(True)
        writer.Transfer(self.document, STEPControl_StepModelType.STEPControl_AsIs)
        assert writer.Write(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        return path


def step_file(path: Path, shape: TopoDS_Shape, *, unit: str = "MM") -> Path:
    document = Document()
    document.part(shape, "part")
    return document.write(path, unit=unit)


def refer_to_file(path: Path, name: str) -> None:
    """Lets the only part of a STEP file have a second shape, in another file."""
    text = path.read_text()
    (definition,) = re.findall(r"(#\d+) = PRODUCT_DEFINITION\(", text)
    (shape,) = re.findall(r"= SHAPE_DEFINITION_REPRESENTATION\(#\d+,(#\d+)\)", text)
    reference = f"""#9001 = DOCUMENT_FILE('{name}','',$,#9002,'',$);
#9002 = DOCUMENT_TYPE('geometry');
#9003 = APPLIED_DOCUMENT_REFERENCE(#9001,'',({definition}));
#9004 = ROLE_ASSOCIATION(#9005,#9003);
#9005 = OBJECT_ROLE('mandatory','');
#9006 = PROPERTY_DEFINITION('external definition','',#9001);
#9007 = PROPERTY_DEFINITION_REPRESENTATION(#9006,{shape});
"""
    head, end, tail = text.partition("ENDSEC;\nEND-ISO")
    path.write_text(head + reference + end + tail)


def iges_file(path: Path, shape: TopoDS_Shape, *, solids: bool = False, unit: str = "MM") -> Path:
    """solids: B-rep (186), else trimmed surfaces (144)."""
    occt.initialize()
    writer = IGESControl_Writer(unit, 1 if solids else 0)
    assert writer.AddShape(shape)
    writer.ComputeModel()
    assert writer.Write(str(path), False)
    return path


def brep_file(path: Path, shape: TopoDS_Shape) -> Path:
    assert BRepTools.Write_s(shape, str(path))
    return path
