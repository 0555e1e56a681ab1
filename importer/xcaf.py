"""From an XCAF document to a Scene: tree, instances, names, colours, layers.

Colours follow OCCT's rule: what stands deeper in the tree wins, a component's own colour wins over its
part's, and a surface colour over a generic one. A colour given to one occurrence deep in the tree (STEP's
overriding styles of a specified higher usage) wins over all of these. Curve colours do not colour surfaces.
"""

from OCP.Quantity import Quantity_ColorRGBA
from OCP.TCollection import TCollection_AsciiString, TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence, TDF_Tool
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape
from OCP.XCAFDoc import (
    XCAFDoc_ColorTool,
    XCAFDoc_ColorType,
    XCAFDoc_DocumentTool,
    XCAFDoc_LayerTool,
    XCAFDoc_ShapeTool,
)

from .occt import faces_of
from .scene import Color, Part, Scene

_MADE_UP = ("NONE", "COMPOUND", "COMPSOLID", "SOLID", "SHELL", "FACE", "ASSEMBLY")
_FACE: int = TopAbs_ShapeEnum.TopAbs_FACE.value  # of kinds from compounds, 0, to vertices
_SURFACE_COLORS = (XCAFDoc_ColorType.XCAFDoc_ColorSurf, XCAFDoc_ColorType.XCAFDoc_ColorGen)


def read_document(document: TDocStd_Document) -> tuple[Scene, int]:
    """The scene of a document, and how many of its shapes are left out for having no face."""
    walk = _Walk(document)
    free = TDF_LabelSequence()
    walk.shapes.GetFreeShapes(free)
    for label in free:
        walk.visit(label, parent=-1, placement=TopLoc_Location(), inherited=None)
    walk.scene.products, walk.scene.components = len(walk.products), len(walk.components)
    return walk.scene, walk.without_faces


class _Walk:
    def __init__(self, document: TDocStd_Document) -> None:
        self.shapes: XCAFDoc_ShapeTool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self.colors: XCAFDoc_ColorTool = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
        self._layers = _layers_of(document)
        self.scene = Scene()
        self.without_faces = 0
        self.products: set[str] = set()  # label entries
        self.components: set[str] = set()
        self._parts: dict[str, int] = {}  # by label entry; -1: no face in it

    def visit(
        self,
        label: TDF_Label,
        *,
        parent: int,
        placement: TopLoc_Location,
        inherited: Color | None,
        overridden: bool = True,
        layers: tuple[str, ...] = (),
    ) -> None:
        """label: a free shape, or a component of an assembly (a reference with a location).

        layers: of the assemblies above.
        overridden: every component so far says that styles of single occurrences pass through it.
        """
        target = label
        local = TopLoc_Location()
        name = _name(label)
        component_color: Color | None = None
        if XCAFDoc_ShapeTool.IsReference_s(label):
            target = TDF_Label()
            if not XCAFDoc_ShapeTool.GetReferredShape_s(label, target):
                return
            entry = _entry(label)
            self.components.add(entry)
            layers += self._layers.get(entry, ())
            local = XCAFDoc_ShapeTool.GetLocation_s(label)
            component_color = self._color(label)
            overridden = overridden and label.HasChild()
            name = name or _name(target)
        self.products.add(_entry(target))
        if XCAFDoc_ShapeTool.IsAssembly_s(target):
            placement = placement.Multiplied(local)
            node = self.scene.add_node(name, parent, local)
            color = component_color or self._color(target) or inherited
            layers += self._layers.get(_entry(target), ())
            components = TDF_LabelSequence()
            XCAFDoc_ShapeTool.GetComponents_s(target, components)
            for component in components:
                self.visit(
                    component,
                    parent=node,
                    placement=placement,
                    inherited=color,
                    overridden=overridden,
                    layers=layers,
                )
            return
        shape = XCAFDoc_ShapeTool.GetShape_s(target)
        part = self._part(target, shape)
        if part < 0:
            self.without_faces += 1
            return
        color = component_color
        if overridden and parent >= 0:
            color = self._occurrence_color(shape.Moved(placement.Multiplied(local))) or color
        local = local.Multiplied(shape.Location())
        if color is None and self.scene.parts[part].color is None:
            color = inherited
        node = self.scene.add_node(name, parent, local)
        self.scene.place(node, part, placement.Multiplied(local), color, layers)

    def _part(self, label: TDF_Label, shape: TopoDS_Shape) -> int:
        key = _entry(label)
        if key not in self._parts:
            self._parts[key] = -1
            if faces_of(shape).Extent() > 0:
                part = Part(shape.Located(TopLoc_Location()), _name(label), self._color(label))
                part.layers = self._layers.get(key, ())
                self._read_subshapes(label, part)
                self.scene.parts.append(part)
                self._parts[key] = len(self.scene.parts) - 1
        return self._parts[key]

    def _read_subshapes(self, label: TDF_Label, part: Part) -> None:
        """Colours, names and layers of solids, shells and faces of a part."""
        subshapes = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetSubShapes_s(label, subshapes)
        inner: list[tuple[int, TopoDS_Shape, Color]] = []
        for sub in subshapes:
            shape = XCAFDoc_ShapeTool.GetShape_s(sub)
            if shape.IsNull():
                continue
            kind: int = shape.ShapeType().value
            if kind > _FACE:  # loops, edges, vertices
                continue
            for layer in self._layers.get(_entry(sub), ()) if self._layers else ():
                part.face_layers.extend((face, layer) for face in faces_of(shape))
            color = self._color(sub)
            if color is not None:
                inner.append((kind, shape, color))
            if kind == _FACE and (name := _name(sub)):
                part.face_names.append((shape, name))
        # Compounds first, faces last: the innermost colour wins.
        for kind, shape, color in sorted(inner, key=lambda entry: entry[0]):
            if kind == _FACE:
                part.face_colors.append((shape, color))
            else:
                part.face_colors.extend((face, color) for face in faces_of(shape))

    def _color(self, label: TDF_Label) -> Color | None:
        for kind in _SURFACE_COLORS:
            color = Quantity_ColorRGBA()
            if XCAFDoc_ColorTool.GetColor_s(label, kind, color):
                return _linear(color)
        return None

    def _occurrence_color(self, shape: TopoDS_Shape) -> Color | None:
        """shape: a part at its place in the world, by which OCCT finds the occurrence."""
        for kind in _SURFACE_COLORS:
            color = Quantity_ColorRGBA()
            if self.colors.GetInstanceColor(shape, kind, color):
                return _linear(color)
        return None


def _layers_of(document: TDocStd_Document) -> dict[str, tuple[str, ...]]:
    """Label entry of a shape -> names of the layers that it is on."""
    tool: XCAFDoc_LayerTool = XCAFDoc_DocumentTool.LayerTool_s(document.Main())
    found: dict[str, tuple[str, ...]] = {}
    labels = TDF_LabelSequence()
    tool.GetLayerLabels(labels)
    for label in labels:
        text = TCollection_ExtendedString()
        members = TDF_LabelSequence()
        if tool.GetLayer(label, text):
            XCAFDoc_LayerTool.GetShapesOfLayer_s(label, members)
            for member in members:
                entry = _entry(member)
                found[entry] = (*found.get(entry, ()), text.ToExtString())
    return found


def _entry(label: TDF_Label) -> str:
    entry = TCollection_AsciiString()
    TDF_Tool.Entry_s(label, entry)
    return str(entry.ToCString())


def _linear(color: Quantity_ColorRGBA) -> Color:
    rgb = color.GetRGB()
    return rgb.Red(), rgb.Green(), rgb.Blue(), color.Alpha()


def _name(label: TDF_Label) -> str:
    """Name of a label, "" where it has none or OCCT made one up ("SOLID", "=>[0:1:1:2]")."""
    if not label.IsAttribute(TDataStd_Name.GetID_s()):  # FindAttribute on an absent one crashes
        return ""
    attribute = TDataStd_Name()
    label.FindAttribute(TDataStd_Name.GetID_s(), attribute)
    name = attribute.Get().ToExtString().strip()
    return "" if name.startswith("=>[") or name in _MADE_UP else name
