"""Shapes given in Python: cadquery Workplane, Shape, Assembly, build123d objects, OCP shapes.

Neither cadquery nor build123d is imported: what an object is, is told by its attributes. OCP is only
imported for an object that can have come from it. The shapes are taken as they are: no healing.
"""

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .errors import EmptyError, UsageError
from .model import BrepModel
from .report import Report

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

    from .scene import Color, Part, Scene


def is_shape(source: Any) -> bool:
    """Whether from_shape takes this object."""
    return "OCP" in sys.modules and (
        _wrapped(source) is not None or _is_assembly(source) or _is_workplane(source)
    )


def from_shape(source: Any, *, name: str | None = None) -> BrepModel:
    """The model of a shape, in this process. name: of the model, where the object has none.

    Raises UsageError for a foreign object, EmptyError when there is no face in it.
    """
    report = Report(format="shape")
    scene, shown = scene_of(source, name, report)
    from .extract import build_model

    return build_model(scene, report, unit="mm", unit_mm=1.0, source={"name": shown})


def scene_of(source: Any, name: str | None, report: Report) -> "tuple[Scene, str]":
    """The scene of a shape, and what it is called. Raises as from_shape."""
    if not is_shape(source):
        raise UsageError(f"cannot take a shape from {type(source).__name__}")
    from .scene import Scene

    shown = name or str(
        getattr(source, "name", None) or getattr(source, "label", None) or type(source).__name__
    )
    with report.stage("extract"):
        if _is_assembly(source):
            scene = _AssemblyWalk().walk(source)
        elif _is_workplane(source):
            scene = scene_of_shape(
                compound_of([v.wrapped for v in source.vals() if _wrapped(v) is not None]), shown
            )
        elif _children(source):
            scene = Scene()
            _visit_build123d(scene, source, -1, None)
        else:
            scene = scene_of_shape(_wrapped(source), shown, _color(getattr(source, "color", None)))
    if not scene.placed:
        raise EmptyError(f"{shown}: no faces", report=report.as_dict())
    return scene, shown


def scene_of_shape(shape: "TopoDS_Shape", name: str = "", color: "Color | None" = None) -> "Scene":
    """One shape as one part, placed where its own location says."""
    from OCP.TopLoc import TopLoc_Location

    from .scene import Scene

    scene = Scene()
    part = _part(scene, {}, shape, name)
    if part >= 0:
        node = scene.add_node(name, -1, shape.Location())
        scene.place(node, part, TopLoc_Location().Multiplied(shape.Location()), color)
    return scene


def _part(scene: "Scene", known: dict[Any, int], shape: "TopoDS_Shape", name: str) -> int:
    """Index of the part of a shape, one for all its placements; -1 when it has no face."""
    from OCP.TopLoc import TopLoc_Location

    from .occt import faces_of
    from .scene import Part

    key = (shape.TShape(), shape.Orientation()) if not shape.IsNull() else None
    if key is None or faces_of(shape).Extent() == 0:
        return -1
    if key not in known:
        scene.parts.append(Part(shape.Located(TopLoc_Location()), name))
        known[key] = len(scene.parts) - 1
    return known[key]


class _AssemblyWalk:
    """cadquery.Assembly: each node may hold an object, a colour for all below it, and children."""

    def __init__(self) -> None:
        from .scene import Scene

        self.scene = Scene()
        self._known: dict[Any, int] = {}

    def walk(self, assembly: Any) -> "Scene":
        from OCP.TopLoc import TopLoc_Location

        self._visit(assembly, -1, TopLoc_Location(), None)
        return self.scene

    def _visit(self, assembly: Any, parent: int, placement: Any, inherited: "Color | None") -> None:
        local = assembly.loc.wrapped
        placement = placement.Multiplied(local)
        color = _color(assembly.color) or inherited
        node = self.scene.add_node(str(assembly.name), parent, local)
        shapes = [s.wrapped for s in assembly.shapes if _wrapped(s) is not None]
        leaf_here = not assembly.children
        if shapes:
            shape = compound_of(shapes)
            index = _part(self.scene, self._known, shape, str(assembly.name))
            if index >= 0:
                own = shape.Location()
                leaf = node
                if not leaf_here:
                    leaf = self.scene.add_node(f"{assembly.name}_part", node, own)
                elif not own.IsIdentity():
                    self.scene.nodes[node].local = local.Multiplied(own)
                self.scene.place(leaf, index, placement.Multiplied(own), color)
                self._read_faces(assembly, self.scene.parts[index])
        for child in assembly.children:
            self._visit(child, node, placement, color)

    def _read_faces(self, assembly: Any, part: "Part") -> None:
        """Colours and names given to single faces (Assembly.addSubshape)."""
        for attribute, target in (
            ("_subshape_colors", part.face_colors),
            ("_subshape_names", part.face_names),
        ):
            values = getattr(assembly, attribute, None)
            if not isinstance(values, Mapping):
                continue
            for shape, value in values.items():
                if _wrapped(shape) is None or shape.wrapped.ShapeType().name != "TopAbs_FACE":
                    continue
                entry: Any = _color(value) if attribute == "_subshape_colors" else str(value)
                if entry:
                    target.append((shape.wrapped, entry))


def _visit_build123d(
    scene: "Scene", item: Any, parent: int, inherited: "Color | None", placement: Any = None
) -> None:
    """build123d: children hold shapes relative to their parent's location."""
    from OCP.TopLoc import TopLoc_Location

    if placement is None:
        placement = TopLoc_Location()
    local = item.wrapped.Location() if _wrapped(item) is not None else TopLoc_Location()
    placement = placement.Multiplied(local)
    label = str(getattr(item, "label", "") or type(item).__name__)
    color = _color(getattr(item, "color", None)) or inherited
    node = scene.add_node(label, parent, local)
    children = _children(item)
    for child in children:
        _visit_build123d(scene, child, node, color, placement)
    if not children and _wrapped(item) is not None:
        known = {(p.shape.TShape(), p.shape.Orientation()): i for i, p in enumerate(scene.parts)}
        index = _part(scene, known, item.wrapped, label)
        if index >= 0:
            scene.place(node, index, placement, color)


def compound_of(shapes: "list[TopoDS_Shape]") -> "TopoDS_Shape":
    """One shape that holds all; the only one itself."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    if len(shapes) == 1:
        return shapes[0]
    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    for shape in shapes:
        builder.Add(compound, shape)
    return compound


def _wrapped(source: Any) -> "TopoDS_Shape | None":
    """The TopoDS_Shape in or behind an object, None when there is none."""
    from OCP.TopoDS import TopoDS_Shape

    if isinstance(source, TopoDS_Shape):
        return source
    wrapped = getattr(source, "wrapped", None)
    return wrapped if isinstance(wrapped, TopoDS_Shape) else None


def _is_assembly(source: Any) -> bool:
    return all(hasattr(source, name) for name in ("children", "shapes", "loc", "color", "name"))


def _is_workplane(source: Any) -> bool:
    return callable(getattr(source, "vals", None)) and hasattr(source, "objects")


def _children(source: Any) -> tuple[Any, ...]:
    children = getattr(source, "children", ())
    return tuple(children) if isinstance(children, list | tuple) else ()


def _color(value: Any) -> "Color | None":
    """cadquery.Color and build123d.Color wrap a Quantity_ColorRGBA."""
    wrapped = getattr(value, "wrapped", value)
    if wrapped is None or not hasattr(wrapped, "GetRGB"):
        return None
    rgb = wrapped.GetRGB()
    return rgb.Red(), rgb.Green(), rgb.Blue(), wrapped.Alpha()
