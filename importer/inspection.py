"""Inspection: what OpenCascade and a file's text say about a model, beside the model itself. Plain records.

Lengths are mm, angles radians, areas mm^2, volumes mm^3; a prototype's numbers are in its own coordinates.
Faces bear the numbers of ``Model.faces``. Edges are numbered within their prototype, as in the store.
"""

from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Count:
    """declared: in the text of the file, None where it cannot say. arrived: in the model, None where nothing
    of this kind is kept. Prototypes count once, as in the file.

    exact: what is declared has to arrive as such. Edges, vertices and loops need not: OpenCascade cuts closed
    faces open along seams, which joins loops and splits edges.
    """

    name: str
    declared: int | None
    arrived: int | None
    exact: bool = True

    @property
    def missing(self) -> int:
        """How many of what has to arrive did not."""
        if not self.exact or self.declared is None or self.arrived is None:
            return 0
        return max(0, self.declared - self.arrived)


@dataclass(frozen=True)
class Lost:
    """An entity that did not arrive, or not as it was. severity: as of report.Issue."""

    entity: str
    kind: str
    reason: str
    severity: Severity


@dataclass(frozen=True)
class ValidationProperty:
    """A geometric validation property of a STEP file and what was measured.

    entity: "#12", its PROPERTY_DEFINITION. value, measured: mm, mm^2, mm^3; measured is None where there is
    nothing to measure. of: what it belongs to, such as "part bolt" or "instance bolt_3 in dm1"; prototype:
    its index, or -1. relative: |difference| / value; for a centroid the distance over the diagonal of the
    model; None where there is nothing to compare. reason: why it has none, or is not to be compared.
    """

    entity: str
    quantity: Literal["volume", "area", "centroid"]
    of: str
    prototype: int
    value: float | tuple[float, ...]
    measured: float | tuple[float, ...] | None
    relative: float | None
    reason: str = ""


@dataclass(frozen=True)
class Topology:
    """How many there are. An edge is a seam where one face uses it twice; free where one face uses it once;
    non-manifold where it is used more than twice, or twice in one direction, within a shell."""

    solids: int = 0
    shells: int = 0
    closed_shells: int = 0
    faces: int = 0
    loops: int = 0
    edges: int = 0
    vertices: int = 0
    seam_edges: int = 0
    degenerate_edges: int = 0
    free_edges: int = 0
    nonmanifold_edges: int = 0
    lone_faces: int = 0  # in no shell
    inside_out_shells: int = 0  # closed ones that bound a negative volume, and no hollow
    faces_by_kind: dict[str, int] = field(default_factory=dict)
    edges_by_kind: dict[str, int] = field(default_factory=dict)

    def times(self, factor: int) -> "Topology":
        """Of so many instances."""
        values: dict[str, Any] = {f.name: _times(getattr(self, f.name), factor) for f in fields(self)}
        return Topology(**values)

    def plus(self, other: "Topology") -> "Topology":
        """Of both."""
        values: dict[str, Any] = {
            f.name: _sum(getattr(self, f.name), getattr(other, f.name)) for f in fields(self)
        }
        return Topology(**values)


def _times(value: Any, factor: int) -> Any:
    if isinstance(value, dict):
        return {key: count * factor for key, count in value.items()}
    return value * factor


def _sum(a: Any, b: Any) -> Any:
    if isinstance(a, dict):
        return {key: a.get(key, 0) + b.get(key, 0) for key in sorted(a.keys() | b.keys())}
    return a + b


@dataclass(frozen=True)
class Mass:
    """Mass properties at density 1.

    Integrated by trimray over the exact surfaces, trimmed by their p-curves, as ``Model.mass_properties``.
    volume, centroid and inertia are of the closed shells; centroid and inertia are None without any. The
    inertia is about the centroid, as the 9 numbers of a 3x3 matrix. area is of all faces.
    volume_error, area_error: the integration's own error. volume_noise, area_noise: what the distances of
    the p-curves from their edges can amount to: the shape itself is not known any better.
    left_out: numbers of the faces that are in none of it since they cannot be drawn, nor are their shells
    in the volume.
    Tight bounds are ``Model.bounds``.
    """

    volume: float = 0.0
    volume_error: float = 0.0
    volume_noise: float = 0.0
    area: float = 0.0
    area_error: float = 0.0
    area_noise: float = 0.0
    centroid: tuple[float, ...] | None = None
    inertia: tuple[float, ...] | None = None
    left_out: tuple[int, ...] = ()


@dataclass(frozen=True)
class Prototype:
    """instances: how often it stands in the world. faces: (first, last + 1) of its face numbers."""

    name: str
    instances: int
    faces: tuple[int, int]
    topology: Topology
    mass: Mass


@dataclass(frozen=True)
class Fault:
    """Something that is wrong with a shape, in plain words.

    kind: "invalid" (OpenCascade's own check), "free edge", "non-manifold edge", "edge off its face",
    "edge out of step", "vertex off its edge", "inside out" or "not checked". faces: numbers of the faces that
    it concerns. edge: its number, or -1. value: mm, and allowed, the tolerance that it exceeds, where it is a
    distance.
    """

    kind: str
    what: str
    prototype: int
    faces: tuple[int, ...] = ()
    edge: int = -1
    value: float | None = None
    allowed: float | None = None


@dataclass(frozen=True)
class Edges:
    """Every edge that bounds a face; arrays of one length n.

    faces: (n, 2) int32 numbers of the first two faces that use it, -1 for none; a seam has its face twice.
    uses: by faces. length: mm. tolerance: mm, as declared. deviation: largest distance of one of its
    p-curves, put on its surface, from the edge. gap: largest distance between both surfaces at one parameter
    of the edge (G0), nan without a second face. angle: largest angle between both normals (G1), nan likewise.
    smooth: the file or its reader claims that the faces meet tangentially. degenerate edges (a pole) have
    length 0.
    """

    prototype: npt.NDArray[np.int32]
    edge: npt.NDArray[np.int32]
    faces: npt.NDArray[np.int32]
    uses: npt.NDArray[np.int32]
    length: npt.NDArray[np.float64]
    tolerance: npt.NDArray[np.float64]
    deviation: npt.NDArray[np.float64]
    gap: npt.NDArray[np.float64]
    angle: npt.NDArray[np.float64]
    smooth: npt.NDArray[np.bool_]

    def worst(self, column: str, count: int = 10) -> list[dict[str, Any]]:
        """The edges with the largest deviation, gap or angle, largest first, JSON-able."""
        values = getattr(self, column)
        order = np.argsort(-np.nan_to_num(values, nan=-1.0), kind="stable")[:count]
        return [self._row(int(i)) for i in order if not np.isnan(values[i])]

    def _row(self, i: int) -> dict[str, Any]:
        row = {f.name: getattr(self, f.name)[i].tolist() for f in fields(self)}
        return {k: None if isinstance(v, float) and np.isnan(v) else v for k, v in row.items()}


@dataclass(frozen=True)
class Inspection:
    """All of it. ``topology`` and ``mass`` are of the whole model, every instance counted.

    entities: how many records of each type stand in the file's text (STEP: by name, IGES: by type number).
    layers: name of a layer -> numbers of the "faces" and "instances" on it, as in ``Model.layers``.
    report: of the importer. face_areas: (faces,) mm^2, by face number; nan for faces that cannot be drawn.
    """

    name: str
    format: str
    unit: str
    unit_mm: float
    source: dict[str, Any]
    entities: dict[str, int]
    counts: tuple[Count, ...]
    lost: tuple[Lost, ...]
    properties: tuple[ValidationProperty, ...]
    topology: Topology
    mass: Mass
    prototypes: tuple[Prototype, ...]
    faults: tuple[Fault, ...]
    edges: Edges
    face_areas: npt.NDArray[np.float64]
    layers: dict[str, dict[str, list[int]]] = field(default_factory=dict)
    report: dict[str, Any] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)

    def as_dict(self, worst: int = 10) -> dict[str, Any]:
        """JSON-able. worst: how many edges are listed by each of deviation, gap and angle."""
        facts = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("edges", "face_areas")}
        plain: dict[str, Any] = {name: _plain(value) for name, value in facts.items()}
        plain["worst_edges"] = {by: self.edges.worst(by, worst) for by in ("deviation", "gap", "angle")}
        return plain


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    return value
