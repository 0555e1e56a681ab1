"""From a BrepModel, as the importer leaves it, to an XCAF document."""

import io
from pathlib import Path

from OCP.BinTools import BinTools_ShapeSet

from ..importer import wire
from ..importer.model import NO_COLOR, BrepModel
from ..importer.occt import faces_of
from .document import Color, Part, Writable, writable


def document_of(model: BrepModel) -> Writable:
    """The model's own shapes, in a document with its tree, names and colours."""
    shapes = BinTools_ShapeSet()
    shapes.Read(io.BytesIO(model.brep))
    colors: dict[int, Color] = dict(
        zip(model.face_color_shapes.tolist(), model.face_colors.tolist(), strict=True)
    )
    roots, part_colors = model.prototype_shapes.tolist(), model.prototype_colors.tolist()
    parts = [
        Part(shapes.Shape(root), name, color)
        for root, name, color in zip(roots, model.prototype_names, part_colors, strict=True)
    ]
    holders = [faces_of(part.shape) for part in parts]
    for number in sorted(colors.keys() | model.face_names.keys()):
        face = shapes.Shape(number)
        entry = face, colors.get(number, NO_COLOR), model.face_names.get(number, "")
        for part, held in zip(parts, holders, strict=True):
            if held.Contains(face):
                part.faces.append(entry)
    return writable(
        model.meta(), parts, model.instance_prototypes, model.instance_placements, model.instance_colors
    )


def save_model(model: BrepModel, path: Path) -> None:
    """For load_model in another process."""
    with path.open("wb") as file:
        wire.send_model(file, model)


def load_model(path: Path) -> BrepModel:
    ((message, blobs),) = wire.Inbox().feed(path.read_bytes())
    model = wire.model_of(message["model"], blobs)
    assert isinstance(model, BrepModel)
    return model
