"""From a scene, as a reader leaves it, to an Inspection."""

import math
from collections import Counter
from dataclasses import dataclass, fields, replace

import numpy as np
from OCP.TopoDS import TopoDS_Shape

from .. import _core
from . import declared, inspect_mass, inspect_validity
from .build_store import build_store
from .errors import InputError
from .extract import build_model
from .inspect_edges import EdgeFacts, inspect_edges
from .inspect_mass import Measured
from .inspect_shape import Walk, counts, walk_prototype
from .inspection import Fault, Inspection, Prototype, Topology
from .inspection_wire import edges_of
from .read_file import ReadScene
from .report import Report
from .scene import Scene
from .validation import validation_properties


@dataclass
class _Part:
    """What is known of one prototype."""

    walk: Walk
    measured: Measured
    topology: Topology


def inspect_scene(read: ReadScene, report: Report, *, name: str, data: bytes = b"") -> Inspection:
    """data: the file's bytes, b"" for a shape given in Python."""
    scene = read.scene
    model = build_model(scene, report, unit=read.unit, unit_mm=read.unit_mm, source=read.source)
    with report.stage("measure"):
        walks: list[Walk] = []
        for part in scene.parts:
            walks.append(walk_prototype(part.shape, sum(len(walk.faces) for walk in walks)))
        try:
            store = build_store(model)
        except _core.CoreError as error:
            raise InputError(f"{name}: {error}") from None
        measured = inspect_mass.measure(store, walks)
        bodies = [_part(walk, part) for walk, part in zip(walks, measured, strict=True)]
    faults: list[Fault] = []
    rows: list[EdgeFacts] = []
    with report.stage("edges"):
        for index, body in enumerate(bodies):
            _add_edges(index, body, rows, faults)
    with report.stage("check"):
        for index, body in enumerate(bodies):
            faults.extend(inspect_validity.check(body.walk, index))
    places = Counter(model.instance_prototypes.tolist())
    prototypes = tuple(
        Prototype(
            name=scene.parts[index].name,
            instances=places[index],
            faces=_face_range(walks, index),
            topology=body.topology,
            mass=body.measured.mass,
        )
        for index, body in enumerate(bodies)
    )
    topology = Topology()
    for prototype in prototypes:
        topology = topology.plus(prototype.topology.times(prototype.instances))
    mass = inspect_mass.whole(
        [body.measured for body in bodies], model.instance_prototypes.tolist(), model.instance_placements
    )
    entities = declared.entity_counts(report.format, data)
    with report.stage("properties"):
        measured = [body.measured for body in bodies]
        solids = [body.topology.solids for body in bodies]
        properties = validation_properties(data, scene, model, measured, solids, _diagonal(store))
    return Inspection(
        name=name,
        format=report.format,
        unit=read.unit,
        unit_mm=read.unit_mm,
        source=read.source,
        entities=entities,
        counts=declared.compare(entities, data, report, scene, prototypes),
        lost=declared.lost_entities(report),
        properties=properties,
        topology=topology,
        mass=mass,
        prototypes=prototypes,
        faults=tuple(faults),
        edges=edges_of({f.name: [getattr(row, f.name) for row in rows] for f in fields(EdgeFacts)}),
        face_areas=np.concatenate([body.measured.face_areas for body in bodies]),
        layers=_layers(scene, walks),
        report=report.as_dict(),
        seconds=report.as_dict()["seconds"],
    )


def _layers(scene: Scene, walks: list[Walk]) -> dict[str, dict[str, list[int]]]:
    found: dict[str, dict[str, set[int]]] = {}

    def on(layer: str, kind: str) -> set[int]:
        return found.setdefault(layer, {"faces": set(), "instances": set()})[kind]

    for part, walk in zip(scene.parts, walks, strict=True):
        for layer in part.layers:
            on(layer, "faces").update(use.number for use in walk.faces)
        by_shape: dict[TopoDS_Shape, list[int]] = {}
        for use in walk.faces if part.face_layers else ():
            by_shape.setdefault(use.face.TShape(), []).append(use.number)
        for face, layer in part.face_layers:
            on(layer, "faces").update(by_shape.get(face.TShape(), ()))
    for index, placed in enumerate(scene.placed):
        for layer in placed.layers:
            on(layer, "instances").add(index)
    return {name: {kind: sorted(ids) for kind, ids in sets.items()} for name, sets in sorted(found.items())}


def _part(walk: Walk, measured: Measured) -> _Part:
    return _Part(walk, measured, counts(walk, len(measured.inside_out)))


def _add_edges(index: int, part: _Part, rows: list[EdgeFacts], faults: list[Fault]) -> None:
    """Adds the facts of a prototype's edges, and the noise of its mass properties that comes from them."""
    found = inspect_edges(part.walk, index, part.measured.moments.origin)
    rows.extend(found.facts)
    faults.extend(found.faults)
    closed = any(shell.closed for shell in part.walk.shells)
    mass = replace(
        part.measured.mass,
        area_noise=found.area_noise,
        volume_noise=found.volume_noise if closed else 0.0,
    )
    part.measured = replace(part.measured, mass=mass)
    for shell in part.measured.inside_out:
        numbers = tuple(use.number for use in part.walk.shells[shell].faces)
        what = "a closed shell whose faces look inwards"
        faults.append(Fault("inside out", what, index, numbers))


def _face_range(walks: list[Walk], index: int) -> tuple[int, int]:
    first = sum(len(walk.faces) for walk in walks[:index])
    return first, first + len(walks[index].faces)


def _diagonal(store: _core.Store) -> float:
    """Of the whole model; 0 where nothing can be drawn."""
    low, high = store.extent()[0]
    diagonal = float(np.linalg.norm(high - low))
    return diagonal if math.isfinite(diagonal) else 0.0
