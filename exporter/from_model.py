"""From a BrepModel, as the importer leaves it, to an XCAF document."""

import io
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BinTools import BinTools_ShapeSet

from trimray.importer.shapes import compound_of

from ..importer import wire
from ..importer.model import BrepModel
from ..importer.occt import faces_of, new_document
from .document import Color, DocumentBuilder, Part, kNoColor, location_of, nodes_of
from .from_store import Rebuilt


def document_of(model: BrepModel) -> Rebuilt:
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
    about: dict[str, Any] = model.meta()
    holders = [faces_of(part.shape) for part in parts]
    for number in sorted(colors.keys() | model.face_names.keys()):
        face = shapes.Shape(number)
        entry = face, colors.get(number, kNoColor), model.face_names.get(number, "")
        for part, held in zip(parts, holders, strict=True):
            if held.Contains(face):
                part.faces.append(entry)
    instances, placements = model.instance_prototypes.tolist(), model.instance_placements
    nodes = nodes_of(about, instances, placements, model.instance_colors)
    document = new_document()
    filled = DocumentBuilder(document, parts, nodes)
    world = compound_of(
        [
            parts[part].shape.Moved(location_of(np.reshape(rows, (3, 4))), False)
            for part, rows in zip(instances, placements, strict=True)
        ]
    )
    return Rebuilt(document, world, model.unit, [(-1, text) for text in filled.issues])


def save_model(model: BrepModel, path: Path) -> None:
    """For load_model in another process."""
    with path.open("wb") as file:
        wire.send_model(file, model)


def load_model(path: Path) -> BrepModel:
    ((message, blobs),) = wire.Inbox().feed(path.read_bytes())
    model = wire.model_of(message["model"], blobs)
    assert isinstance(model, BrepModel)
    return model
