"""From a Scene to a BrepModel: one BinTools stream for all parts, and the arrays beside it."""

import io
from typing import Any

import numpy as np
from OCP.BinTools import BinTools_FormatVersion, BinTools_ShapeSet
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape

from .model import NO_COLOR, BrepModel, Float32s, Instance, TreeNode
from .occt import faces_of
from .report import Report
from .scene import Color, Scene, matrix


def build_model(
    scene: Scene, report: Report, *, unit: str, unit_mm: float, source: dict[str, Any]
) -> BrepModel:
    """Writes every part once. Sets the face counts of ``report`` and puts it into the model."""
    with report.stage("extract"):
        shape_set = BinTools_ShapeSet()
        shape_set.SetFormatNb(BinTools_FormatVersion.BinTools_FormatVersion_VERSION_4.value)
        shape_set.SetWithTriangles(False)  # a face without a surface keeps its triangles all the same
        shape_set.SetWithNormals(True)  # of those: they tell which side is outside
        roots = [shape_set.Add(_at_origin(part.shape)) for part in scene.parts]
        face_colors: dict[int, Color] = {}
        face_names: dict[int, str] = {}
        for part in scene.parts:
            for face, color in part.face_colors:
                face_colors[shape_set.Index(_at_origin(face))] = color
            for face, name in part.face_names:
                face_names[shape_set.Index(_at_origin(face))] = name
        layers = _layers(scene, shape_set)
        face_colors.pop(0, None)  # 0: not part of any prototype
        face_names.pop(0, None)
        stream = io.BytesIO()
        shape_set.Write(stream)
        _count_faces(scene, report)
    model = BrepModel(
        brep=stream.getvalue(),
        prototype_shapes=np.array(roots, dtype=np.int32),
        prototype_colors=_encode([part.color for part in scene.parts]),
        face_color_shapes=np.array(sorted(face_colors), dtype=np.int32),
        face_colors=_encode([face_colors[shape] for shape in sorted(face_colors)]),
        instance_prototypes=np.array([scene.nodes[p.node].part for p in scene.placed], dtype=np.int32),
        instance_placements=np.array([matrix(p.placement) for p in scene.placed], dtype=np.float64).reshape(
            -1, 12
        ),
        instance_colors=_encode([p.color for p in scene.placed]),
        prototype_names=tuple(part.name for part in scene.parts),
        face_names=face_names,
        layers=layers,
        instances=tuple(Instance(scene.nodes[p.node].name, scene.path(p.node), p.node) for p in scene.placed),
        tree=tuple(TreeNode(n.name, n.parent, n.part, matrix(n.local)) for n in scene.nodes),
        unit=unit,
        unit_mm=unit_mm,
        source=source,
        report=report.as_dict(),
    )
    model.validate()
    return model


def _layers(scene: Scene, shape_set: BinTools_ShapeSet) -> dict[str, dict[str, list[int]]]:
    """As of BrepModel."""
    found: dict[str, dict[str, list[int]]] = {}

    def add(layer: str, kind: str, number: int) -> None:
        known = found.setdefault(layer, {"prototypes": [], "instances": [], "shapes": []})[kind]
        if number not in known[-1:]:
            known.append(number)

    for index, part in enumerate(scene.parts):
        for layer in part.layers:
            add(layer, "prototypes", index)
        for face, layer in part.face_layers:
            if shape := shape_set.Index(_at_origin(face)):
                add(layer, "shapes", shape)
    for index, placed in enumerate(scene.placed):
        for layer in placed.layers:
            add(layer, "instances", index)
    return dict(sorted(found.items()))


def _at_origin(shape: TopoDS_Shape) -> TopoDS_Shape:
    return shape.Located(TopLoc_Location())


def _count_faces(scene: Scene, report: Report) -> None:
    """report.faces: distinct faces by TShape; report.face_uses: over all instances."""
    distinct: set[TopoDS_Shape] = set()
    uses = []
    for part in scene.parts:
        faces = faces_of(part.shape)
        uses.append(faces.Extent())
        distinct.update(face.TShape() for face in faces)
    report.faces = len(distinct)
    report.face_uses = sum(uses[scene.nodes[placed.node].part] for placed in scene.placed)


def _encode(colors: list[Color | None] | list[Color]) -> Float32s:
    """(n, 4) float32, sRGB-encoded, from linear colours; NO_COLOR for None."""
    array = np.array([NO_COLOR if color is None else color for color in colors], dtype=np.float64).reshape(
        -1, 4
    )
    given = array[:, 0] >= 0.0
    linear = np.clip(array[given, :3], 0.0, 1.0)
    array[given, :3] = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    # Quantity_Color holds floats: what a file says in up to five digits comes back as said.
    array[given, :3] = np.round(array[given, :3], 6)
    return np.ascontiguousarray(array, dtype=np.float32)
