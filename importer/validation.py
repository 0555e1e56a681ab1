"""Geometric validation properties of a STEP file (CAx-IF recommended practice), beside what was measured.

What they belong to is followed through the text: a part, an assembly, an instance of either (in the
coordinates of what holds it), or a body within a part.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from OCP.StepBasic import StepBasic_ProductDefinition
from OCP.STEPConstruct import STEPConstruct_ValidationProps

from . import inspect_mass
from .inspect_mass import Measured
from .inspection import Mass, ValidationProperty
from .model import BrepModel
from .occurrences import Occurrences
from .scene import Scene
from .step_records import StepRecords, number_in, reference, references, split, text_of
from .step_text import StepText

Quantity = Literal["volume", "area", "centroid"]
_NAME = "geometric validation property"
_QUANTITIES: dict[str, Quantity] = {
    "volume measure": "volume",
    "surface area measure": "area",
    "wetted area measure": "area",
    "centre point": "centroid",
    "center point": "centroid",
}
_BLANK = "the file says 0 instead of a value"
_DIMENSION = {"volume": 3, "area": 2}


@dataclass(frozen=True)
class Declared:
    entity: int
    quantity: Quantity
    value: float | tuple[float, ...]  # mm
    target: int  # record that it belongs to


@dataclass(frozen=True)
class Target:
    """of: in words. mass: of it, None where there is none, for that reason. diagonal: mm."""

    of: str
    prototype: int = -1
    mass: Mass | None = None
    reason: str = ""


def validation_properties(
    data: bytes,
    scene: Scene,
    model: BrepModel,
    parts: list[Measured],
    solids: list[int],
    diagonal: float,
) -> tuple[ValidationProperty, ...]:
    """data: the file's bytes. parts, and how many solids they have: by prototype. diagonal: mm, of the model,
    to judge centroids by."""
    if _NAME.encode() not in data.lower().replace(b"_", b" ") or scene.session is None:
        return ()
    records = StepRecords(data)
    targets = _Targets(data, records, scene, model, parts, solids)
    declared = declared_properties(records)
    # Some writers fill the form with zeros.
    blank = {found.entity for found in declared if found.value == 0.0}
    return tuple(
        _beside(found, targets.of(found.target), diagonal, _why_apart(data, found, blank))
        for found in declared
    )


def _why_apart(data: bytes, found: Declared, blank: set[int]) -> str:
    """Why a value may be another than that of the shape, "" where there is no reason."""
    if found.entity in blank:
        return _BLANK
    if found.quantity == "centroid" and b"density measure" in data:
        return "the file gives densities, which the centroid of an assembly may include"
    return ""


def declared_properties(records: StepRecords) -> list[Declared]:
    """Those whose units are understood."""
    found: list[Declared] = []
    for link in records.of_type("PROPERTY_DEFINITION_REPRESENTATION"):
        arguments = records.parts(link)["PROPERTY_DEFINITION_REPRESENTATION"]
        if len(arguments) != 2:
            continue
        entity = reference(arguments[0])
        definition = records.parts(entity).get("PROPERTY_DEFINITION", [])
        if len(definition) != 3 or text_of(definition[0]).lower().replace("_", " ").strip() != _NAME:
            continue
        for body in records.parts(reference(arguments[1])).values():
            if len(body) == 3:
                for item in references(body[1]):
                    found.extend(_read(records, entity, item, reference(body[2]), reference(definition[2])))
    return found


def _read(records: StepRecords, entity: int, item: int, context: int, target: int) -> list[Declared]:
    parts = records.parts(item)
    if "CARTESIAN_POINT" in parts:
        name, coordinates = (parts["CARTESIAN_POINT"] + ["", ""])[:2]
        unit = records.context_mm(context)
        values = [number_in(c) for c in split(coordinates.strip()[1:-1])]
        if _quantity(name) != "centroid" or unit is None or len(values) != 3 or None in values:
            return []
        point = tuple(float(v) * unit for v in values if v is not None)
        return [Declared(entity, "centroid", point, target)]
    if "MEASURE_WITH_UNIT" in parts:  # the complex form
        name = (parts.get("REPRESENTATION_ITEM") or [""])[0]
        value, measure = (parts["MEASURE_WITH_UNIT"] + ["", ""])[:2]
    elif len(parts.get("MEASURE_REPRESENTATION_ITEM", [])) == 3:
        name, value, measure = parts["MEASURE_REPRESENTATION_ITEM"]
    else:
        return []
    quantity, number = _quantity(name), number_in(value)
    if quantity is None or quantity == "centroid" or number is None:
        return []
    unit = records.measure_mm(reference(measure), _DIMENSION[quantity])
    return [] if unit is None else [Declared(entity, quantity, number * unit, target)]


def _quantity(name: str) -> Quantity | None:
    return _QUANTITIES.get(text_of(name).lower().replace("_", " ").strip())


def _beside(found: Declared, target: Target, diagonal: float, why: str) -> ValidationProperty:
    measured: float | tuple[float, ...] | None = None
    reason = target.reason or (why if why == _BLANK or target.prototype < 0 else "")
    if target.mass is not None:
        measured = getattr(target.mass, found.quantity)
        if target.mass.left_out:
            measured, reason = None, "some of its faces cannot be drawn, and are not measured"
        elif found.quantity != "area" and target.mass.centroid is None:
            measured, reason = None, "nothing in it is closed"
    difference: float | None = None
    if isinstance(measured, tuple) and why != _BLANK and isinstance(found.value, tuple):
        distance = float(np.linalg.norm(np.subtract(measured, found.value)))
        difference = distance / diagonal if diagonal else None
    elif isinstance(measured, float) and why != _BLANK and isinstance(found.value, float):
        difference = abs(measured - found.value) / abs(found.value)
    return ValidationProperty(
        f"#{found.entity}",
        found.quantity,
        target.of,
        target.prototype,
        found.value,
        measured,
        difference,
        reason,
    )


def bodies_of_aspects(records: StepRecords) -> dict[int, int]:
    """SHAPE_ASPECT -> the one item that it picks out of a shape. Writers say it in two ways: by a usage of
    the item, or by a property of the aspect whose representation holds the item."""
    found: dict[int, int] = {}
    for usage in records.of_type("GEOMETRIC_ITEM_SPECIFIC_USAGE"):
        arguments = records.parts(usage)["GEOMETRIC_ITEM_SPECIFIC_USAGE"]
        if len(arguments) == 5:
            found[reference(arguments[2])] = reference(arguments[4])
    for link in records.of_type("SHAPE_DEFINITION_REPRESENTATION"):
        arguments = records.parts(link)["SHAPE_DEFINITION_REPRESENTATION"]
        definition = records.parts(reference(arguments[0])).get("PROPERTY_DEFINITION", [])
        for body in records.parts(reference(arguments[-1])).values():
            items = references(body[1]) if len(body) == 3 else []
            if len(definition) == 3 and len(items) == 1:
                found.setdefault(reference(definition[2]), items[0])
    return found


class _Targets:
    """What properties belong to, and its mass properties."""

    def __init__(
        self,
        data: bytes,
        records: StepRecords,
        scene: Scene,
        model: BrepModel,
        parts: list[Measured],
        solids: list[int],
    ) -> None:
        self.records, self.scene, self.model = records, scene, model
        self.parts, self.solids = parts, solids
        self._numbers = {int(n): i for i, n in enumerate(StepText(data).record_ids, start=1)}
        self._worlds = _worlds(model)
        self._occurrences = Occurrences(records, model)
        self._known: dict[int, Target] = {}
        self._bodies = bodies_of_aspects(records)

    def of(self, record: int) -> Target:
        if record not in self._known:
            self._known[record] = self._find(record)
        return self._known[record]

    def _find(self, record: int) -> Target:
        parts = self.records.parts(record)
        if arguments := parts.get("SHAPE_ASPECT"):
            return self._aspect(record, arguments)
        shape = parts.get("PRODUCT_DEFINITION_SHAPE") or parts.get("PROPERTY_DEFINITION")
        holder = reference(shape[2]) if shape and len(shape) > 2 else record
        kinds = self.records.parts(holder)
        if arguments := kinds.get("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            return self._instance(holder, arguments)
        if any(kind.startswith("PRODUCT_DEFINITION") for kind in kinds):
            return self._product(holder)
        return Target(f"#{record}", reason=f"belongs to {next(iter(kinds), 'nothing')}")

    def _product(self, definition: int) -> Target:
        name = self._occurrences.name(definition)
        shape = self._shape(definition)
        for index, part in enumerate(self.scene.parts):
            if shape is not None and part.shape.TShape() == shape.TShape():
                return Target(f"part {name}", index, self.parts[index].mass)
        node = self._occurrences.node_of.get(definition)
        if node is None:
            return Target(f"part {name}", reason="no such part arrived")
        index = self.model.tree[node].prototype
        if index >= 0:
            return Target(f"part {name}", index, self.parts[index].mass)
        return Target(f"assembly {name}", mass=self._below(node, self._worlds[node]))

    def _instance(self, record: int, arguments: list[str]) -> Target:
        """In the coordinates of the assembly that holds it."""
        name = next((t for t in map(text_of, (arguments[1], arguments[0])) if t.strip()), "")
        of = f"instance {name} in {self._occurrences.name(reference(arguments[3]))}"
        node = self._occurrences.node_of.get(record)
        if node is None:
            return Target(of, reason="no such instance arrived")
        return Target(of, mass=self._below(node, self._worlds[self.model.tree[node].parent]))

    def _aspect(self, record: int, arguments: list[str]) -> Target:
        """A body that a shape aspect picks out of a part: known where it is the part's only one."""
        part = self.of(reference(arguments[2])) if len(arguments) > 2 else Target("")
        item = self._bodies.get(record)
        if item is None:
            return Target(f"an aspect of {part.of}", part.prototype, reason="it does not name a body")
        solid = any("BREP" in kind for kind in self.records.parts(item))
        of = f"body #{item} of {part.of}"
        if solid and part.prototype >= 0 and self.solids[part.prototype] == 1:
            return Target(of, part.prototype, part.mass)
        return Target(of, part.prototype, reason="one of several bodies: not told apart")

    def _below(self, node: int, frame: npt.NDArray[np.float64]) -> Mass:
        """Of all that stands at or below a node, in coordinates of the frame (4, 4)."""
        inverse = np.linalg.inv(frame)
        parts, placements = [], []
        for i, instance in enumerate(self.model.instances):
            at = instance.node
            while at >= 0 and at != node:
                at = self.model.tree[at].parent
            if at == node:
                parts.append(int(self.model.instance_prototypes[i]))
                placements.append((inverse @ _square(self.model.instance_placements[i]))[:3].ravel())
        return inspect_mass.whole(self.parts, parts, np.array(placements)) if parts else Mass()

    def _shape(self, definition: int) -> Any:
        """What OpenCascade made of a PRODUCT_DEFINITION, None where it made no shape."""
        number = self._numbers.get(definition, 0)
        model = self.scene.session.Model()
        if not 0 < number <= model.NbEntities() or len(self._numbers) != model.NbEntities():
            return None
        entity = model.Value(number)
        if not isinstance(entity, StepBasic_ProductDefinition):
            return None
        shape = STEPConstruct_ValidationProps(self.scene.session).GetPropShape(entity)
        return None if shape is None or shape.IsNull() else shape


def _square(placement: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.vstack([np.asarray(placement, dtype=np.float64).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])


def _worlds(model: BrepModel) -> list[npt.NDArray[np.float64]]:
    """(4, 4) placements of all nodes in the world."""
    worlds: list[npt.NDArray[np.float64]] = []
    for node in model.tree:
        own = _square(np.array(node.placement))
        worlds.append(own if node.parent < 0 else worlds[node.parent] @ own)
    return worlds
