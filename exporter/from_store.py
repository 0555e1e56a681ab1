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
    face_names = about.get("face_names") or {}
    named = about.get("named_faces") or {}  # of models of triangles: by face number
    parts = []
    for prototype, name in zip(built, names, strict=True):
        part = Part(prototype.shape, name, prototype.record["color"].tolist())
        for number, face in prototype.faces.items():
            record = arrays["faces"][number]
            color = record["color"].tolist()
            face_name = face_names.get(str(int(record["shape"])), "") or named.get(str(number), "")
            if color[0] >= 0.0 or face_name:
                part.faces.append((face, color, face_name))
        parts.append(part)
    for layer, held in (about.get("layers") or {}).items():
        for number in held.get("prototypes", ()):
            parts[number].layers.append(layer)
        shapes = set(held.get("shapes", ()))
        for prototype, part in zip(built, parts, strict=True) if shapes else ():
            on_it = [f for n, f in prototype.faces.items() if int(arrays["faces"][n]["shape"]) in shapes]
            part.face_layers += [(face, layer) for face in on_it]
    instances = arrays["instances"]
    placements = np.ascontiguousarray(instances["placement"].transpose(0, 2, 1)).reshape(-1, 12)
    issues = [issue for prototype in built for issue in prototype.issues]
    return writable(about, parts, instances["prototype"], placements, instances["color"], issues)
