"""merge: several models as one scene."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _core
from .hierarchy import Hierarchy
from .importer.errors import UsageError
from .model import Model


def merge(models: Sequence[Model]) -> Model:
    """All models in one, each where it stands: one picture, one mesh, one set of face and instance numbers.

    Faces and instances keep their order: first those of the first model, then those of the second, ... Its
    report names the file of every issue. Raises UsageError for no model, or for too many faces together.
    """
    if not models:
        raise UsageError("merge: no models")
    meta = json.dumps(_merged_meta(models), ensure_ascii=False, separators=(",", ":"))
    try:
        store = _core.Store.merge([model._core for model in models], meta)
    except _core.CoreError as error:
        raise UsageError(f"merge: {error}") from None
    bounds = np.array(
        [
            np.min([model._extent[0][0] for model in models], axis=0),
            np.max([model._extent[0][1] for model in models], axis=0),
        ]
    )
    outline = np.concatenate([model._extent[1] for model in models])
    return Model(
        Hierarchy(store),
        seconds=_sums(model._seconds for model in models),
        extent=(bounds, outline),
        cached=all(model._cached for model in models),
        source=" + ".join(model._source for model in models),
    )


def _merged_meta(models: Sequence[Model]) -> dict[str, Any]:
    prototypes: list[Any] = []
    instances: list[Any] = []
    tree: list[Any] = []
    named_faces: dict[str, str] = {}
    layers: dict[str, dict[str, list[int]]] = {}
    faces = 0
    for model in models:
        for name, layer in model.layers.items():
            entry = layers.setdefault(name, {"faces": [], "instances": []})
            entry["faces"] += [number + faces for number in layer.faces]
            entry["instances"] += [number + len(instances) for number in layer.instances]
        meta = model._meta
        nodes, parts = len(tree), len(prototypes)
        # As many as the store has: what follows must not slip.
        names = list(meta.get("prototypes", ()))
        count = len(model._core.prototype_faces())
        prototypes += [*names[:count], *({} for _ in range(count - len(names)))]
        for node in meta.get("tree", ()):
            parent, part = int(node["parent"]), int(node["prototype"])
            tree.append(
                {
                    **node,
                    "parent": parent + nodes if parent >= 0 else -1,
                    "prototype": part + parts if part >= 0 else -1,
                }
            )
        for instance in model.instances:
            known = list(meta.get("instances", ()))
            node = int(known[instance.number]["node"]) if instance.number < len(known) else -1
            instances.append(
                {
                    "name": instance.name,
                    "path": list(instance.path),
                    "node": node + nodes if node >= 0 else -1,
                }
            )
        # Numbers, since the shapes that files number may have the same numbers in each.
        named_faces |= {str(number + faces): name for number, name in model._face_names.items()}
        faces += len(model.faces)
    units = {model.unit for model in models}
    return {
        "unit": units.pop() if len(units) == 1 else "mixed",
        "prototypes": prototypes,
        "instances": instances,
        "tree": tree,
        "named_faces": named_faces,
        "layers": layers,
        "report": _merged_report(models),
        "source": {"files": [model._meta.get("source", {}) for model in models]},
    }


def _merged_report(models: Sequence[Model]) -> dict[str, Any]:
    reports = [(model._source, model._meta.get("report", {})) for model in models]
    declared = [report.get("faces_in_file") for _, report in reports]
    return {
        "faces_in_file": None if None in declared else sum(declared),
        "faces": sum(int(report.get("faces", 0)) for _, report in reports),
        "face_uses": sum(int(report.get("face_uses", 0)) for _, report in reports),
        "issues": [
            {**issue, "entity": f"{name}: {issue['entity']}" if issue["entity"] else name}
            for name, report in reports
            for issue in report.get("issues", ())
        ],
        "issues_left_out": sum(int(report.get("issues_left_out", 0)) for _, report in reports),
        "seconds": _sums(report.get("seconds", {}) for _, report in reports),
        "peak_memory": max(int(report.get("peak_memory", 0)) for _, report in reports),
    }


def _sums(tables: Any) -> dict[str, float]:
    total: dict[str, float] = {}
    for table in tables:
        for name, value in table.items():
            total[name] = total.get(name, 0.0) + value
    return total
