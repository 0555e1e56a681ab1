"""From a NurbsStore back to OpenCascade's B-rep, by the store's arrays alone.

Every surface is made anew in its own kind with the store's very numbers; no refit, no healing, no
approximation. What this proves when the result is compared with the source: the store lost nothing.
"""

import json
from typing import Any

import numpy as np

from .document import Part, Writable, writable
from .topology import PrototypeBuilder


def build_parts(arrays: dict[str, Any]) -> list[PrototypeBuilder]:
    """Every prototype of a store as a shape. arrays: ``Store.arrays()``."""
    return [PrototypeBuilder(arrays, i) for i in range(len(arrays["prototypes"]))]


def rebuild(arrays: dict[str, Any], meta: str) -> Writable:
    """arrays, meta: of a Store. Faces that cannot be said in OpenCascade are left out and listed."""
    about = json.loads(meta) if meta else {}
    built = build_parts(arrays)
    names = [str(p.get("name", "")) for p in about.get("prototypes", ())]
    names += [""] * (len(built) - len(names))
    parts = [
        _part(prototype, name, arrays, about, number)
        for number, (prototype, name) in enumerate(zip(built, names, strict=True))
    ]
    instances = arrays["instances"]
    placements = np.ascontiguousarray(instances["placement"].transpose(0, 2, 1)).reshape(-1, 12)
    issues = [issue for prototype in built for issue in prototype.issues]
    used = np.array(_by_layers(parts, instances["prototype"].tolist(), arrays, about))
    return writable(about, parts, used, placements, instances["color"], issues)


def _part(
    prototype: PrototypeBuilder, name: str, arrays: dict[str, Any], about: dict[str, Any], number: int
) -> Part:
    """With colours, names and layers of its own and of its faces. number: of the prototype."""
    face_names = about.get("face_names") or {}
    named = about.get("named_faces") or {}  # of models of triangles: by face number
    part = Part(prototype.shape, name, prototype.record["color"].tolist())
    shape_of = {face: int(arrays["faces"][face]["shape"]) for face in prototype.faces}
    for face, shape in prototype.faces.items():
        color = arrays["faces"][face]["color"].tolist()
        face_name = face_names.get(str(shape_of[face]), "") or named.get(str(face), "")
        if color[0] >= 0.0 or face_name:
            part.faces.append((shape, color, face_name))
    for layer, held in (about.get("layers") or {}).items():
        if number in held.get("prototypes", ()):
            part.layers.append(layer)
        shapes = set(held.get("shapes", ()))
        part.face_layers += [(s, layer) for face, s in prototype.faces.items() if shape_of[face] in shapes]
    return part


def _by_layers(
    parts: list[Part], prototypes: list[int], arrays: dict[str, Any], about: dict[str, Any]
) -> list[int]:
    """The part of each instance. STEP knows no layers of instances: those that are on other layers than their
    part get a part of their own, which is added to parts.

    prototypes: of the instances.
    """
    on: dict[int, list[str]] = {}
    for layer, held in (about.get("layers") or {}).items():
        for instance in held.get("instances", ()):
            on.setdefault(int(instance), []).append(layer)
    wanted = [
        (prototype, tuple(layer for layer in on.get(i, ()) if layer not in parts[prototype].layers))
        for i, prototype in enumerate(prototypes)
    ]
    # Where all instances are on the same layers, so may be their part.
    numbers: dict[tuple[int, tuple[str, ...]], int] = {}
    free = {prototype for prototype, layers in wanted if layers} - {p for p, layers in wanted if not layers}
    for prototype, layers in wanted:
        if (prototype, layers) in numbers:
            continue
        if not layers or prototype in free:
            number = prototype
            free.discard(prototype)
        else:
            number = len(parts)
            again = PrototypeBuilder(arrays, prototype)
            parts.append(_part(again, parts[prototype].name, arrays, about, prototype))
        numbers[prototype, layers] = number
        parts[number].layers += layers
    return [numbers[key] for key in wanted]
