"""Loose surfaces become one part, so that sewing can join them: IGES lists each as a shape of its own."""

from OCP.BRep import BRep_Builder
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape

from .occt import faces_of
from .scene import Part, Placed, Scene


def merge_loose(scene: Scene, name: str) -> Scene:
    """The scene with all parts that stand alone at the root and hold no solid made one part of that name.

    Colours of parts and instances become those of their faces; the name of a part goes to its only face.
    """
    uses = [0] * len(scene.parts)
    for placed in scene.placed:
        uses[scene.nodes[placed.node].part] += 1
    loose = [p for p in scene.placed if _is_loose(scene, p, uses)]
    if len(loose) < 2:
        return scene
    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    merged = Part(compound, name)
    for placed in loose:
        part = scene.parts[scene.nodes[placed.node].part]
        shape = part.shape.Moved(placed.placement)
        builder.Add(compound, shape)
        faces = list(faces_of(shape))
        color = placed.color or part.color
        if color is not None:
            merged.face_colors += [(face, color) for face in faces]
        merged.face_colors += part.face_colors
        if len(faces) == 1 and part.name:
            merged.face_names.append((faces[0], part.name))
        merged.face_names += part.face_names
    return _replace(scene, loose, merged)


def _is_loose(scene: Scene, placed: Placed, uses: list[int]) -> bool:
    node = scene.nodes[placed.node]
    return node.parent < 0 and uses[node.part] == 1 and not _has_solid(scene.parts[node.part].shape)


def _has_solid(shape: TopoDS_Shape) -> bool:
    return bool(TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_SOLID).More())


def _replace(scene: Scene, loose: list[Placed], merged: Part) -> Scene:
    """A new scene without the loose parts, and with the merged one in front."""
    gone = {placed.node for placed in loose}
    gone_parts = {scene.nodes[node].part for node in gone}
    result = Scene(parts=[merged])
    node = result.add_node(merged.name, -1, TopLoc_Location())
    result.place(node, 0, TopLoc_Location(), None)
    new_part = {-1: -1}
    for index, part in enumerate(scene.parts):
        if index not in gone_parts:
            new_part[index] = len(result.parts)
            result.parts.append(part)
    new_node = {-1: -1}
    for index, old in enumerate(scene.nodes):
        if index not in gone:
            new_node[index] = result.add_node(old.name, new_node[old.parent], old.local)
            result.nodes[-1].part = new_part[old.part]
    for placed in scene.placed:
        if placed.node not in gone:
            result.placed.append(Placed(new_node[placed.node], placed.placement, placed.color))
    return result
