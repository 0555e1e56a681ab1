"""The placed parts of a model as a comparison sees them: by name, by shape and by place."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .side import Float64s, Int64s, Side

# Names that programs make up where the designer gave none: they may change whenever a file is written.
_MADE_UP = re.compile(
    r"""(?ix) \s* ( \d*                                   # entity and occurrence numbers
    | NAUO\d* | Open\ CASCADE\ (STEP|IGES)\ .* | =>\[.*
    | [0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12} (_part)?  # cadquery's names of nodes
    | (NONE|NULL|COMPOUND|COMPSOLID|SOLID|SHELL|FACE|ASSEMBLY|PRODUCT|SHAPE) (_?\d+)?
    ) \s*"""
)
# Classes of Python's shapes, by which the importer calls what has no name.
_CLASSES = frozenset(
    {"Workplane", "Shape", "Solid", "Compound", "CompSolid", "Shell", "Face", "Wire", "Assembly"}
    | {"Part", "Sketch", "Box", "Cylinder", "Cone", "Sphere", "Torus", "Wedge", "BasePartObject", "BuildPart"}
    | {"TopoDS_Shape", "TopoDS_Compound", "TopoDS_CompSolid", "TopoDS_Solid", "TopoDS_Shell", "TopoDS_Face"}
)


def given(name: str, format: str = "") -> str:
    """A name that a designer gave; "" for one that is made up."""
    made_up = _MADE_UP.fullmatch(name) or (format == "shape" and name in _CLASSES)
    return "" if made_up else name.strip()


@dataclass(frozen=True)
class Shape:
    """A prototype. vertices: (n, 3), its own coordinates; kinds: its number of faces by kind."""

    name: str
    vertices: Float64s
    kinds: tuple[tuple[str, int], ...]

    @property
    def center(self) -> Float64s:
        return self.vertices.mean(axis=0) if len(self.vertices) else np.zeros(3)


@dataclass(frozen=True)
class PlacedPart:
    """An instance. path: the names given from the root down to it, without repetitions and without those
    made up. name: its own, "" where none is given. center: of its vertices, world."""

    number: int
    path: tuple[str, ...]
    name: str
    shape: Shape
    placement: Float64s
    center: Float64s

    def call(self) -> str:
        """For people."""
        return "/".join(self.path) or self.name or self.shape.name or f"instance {self.number}"


# Kinds that files do not tell apart: a Bezier surface is a B-spline with one span.
_ALIKE = {"bezier": "bspline"}


def kind_families(kinds: Sequence[str]) -> list[str]:
    return [_ALIKE.get(kind, kind) for kind in kinds]


def shapes_of(side: Side) -> list[Shape]:
    """By prototype."""
    arrays = side.arrays
    names = side.sound._part_names
    kinds = np.array(kind_families(side.sound._core.face_kinds()), dtype=object)
    points = arrays["vertices"]["point"]
    corners, triangles, spans = (
        arrays["mesh_vertices"],
        arrays["mesh_triangles"],
        arrays["faces"]["triangles"],
    )
    result = []
    for number, record in enumerate(arrays["prototypes"]):
        vertices = points[slice(*record["vertices"].tolist())]
        first, last = record["faces"].tolist()
        if not len(vertices) and first < last:
            used = triangles[spans[first][0] : spans[last - 1][1]]
            vertices = corners[np.unique(used)]
        found, counts = np.unique(kinds[first:last].astype(str), return_counts=True)
        name = given(names[number], side.format) if number < len(names) and side.holds("names") else ""
        histogram = tuple(zip(found.tolist(), counts.tolist(), strict=True))
        result.append(Shape(name, np.asarray(vertices, np.float64), histogram))
    return result


def placed_parts(side: Side) -> list[PlacedPart]:
    """All instances, in the order of their numbers."""
    shapes = shapes_of(side)
    result = []
    for instance in side.sound.instances:
        shape = shapes[int(side.prototypes[instance.number])]
        placement = np.asarray(instance.placement, np.float64)
        names = [given(name, side.format) for name in instance.path] if side.holds("names") else []
        path = [name for i, name in enumerate(names) if name and (i == 0 or name != names[i - 1])]
        name = given(instance.name, side.format) if side.holds("names") else ""
        center = placement[:, :3] @ shape.center + placement[:, 3]
        result.append(PlacedPart(instance.number, tuple(path), name, shape, placement, center))
    return result


def face_centers(side: Side) -> Float64s:
    """(f, 3) float64, in the prototype's coordinates: the mean of the control points of a face's edges, or of
    its triangles' corners. The same for the same face, however its file orders edges."""
    arrays = side.arrays
    count = len(arrays["faces"])
    total, weight = np.zeros((count, 3)), np.zeros(count)
    edge_sum, edge_count = edge_sums(side)
    coedges = arrays["coedges"]
    np.add.at(total, coedges["face"], edge_sum[coedges["edge"]])
    np.add.at(weight, coedges["face"], edge_count[coedges["edge"]])
    for face in np.flatnonzero(arrays["faces"]["triangles"][:, 1] > arrays["faces"]["triangles"][:, 0]):
        begin, end = arrays["faces"]["triangles"][face]
        corners = arrays["mesh_vertices"][arrays["mesh_triangles"][begin:end].ravel()]
        total[face], weight[face] = corners.sum(axis=0), len(corners)
    for face in np.flatnonzero(weight == 0):  # no loops: the whole surface
        begin, end = arrays["surfaces"]["ctrl"][arrays["faces"]["surface"][face]]
        points = arrays["ctrl_h"][begin:end]
        if len(points):
            total[face], weight[face] = (points[:, :3] / points[:, 3:]).sum(axis=0), len(points)
    return total / np.maximum(weight, 1)[:, None]


def edge_sums(side: Side) -> tuple[Float64s, Int64s]:
    """By edge: its pieces' control points, summed up, and their number."""
    arrays = side.arrays
    points = arrays["edge_ctrl_h"][:, :3] / arrays["edge_ctrl_h"][:, 3:]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(points, axis=0)])
    pieces, spans = arrays["edge_pieces"]["ctrl"], arrays["edges"]["pieces"]
    count = len(spans)
    total, number = np.zeros((count, 3)), np.zeros(count, np.int64)
    full = spans[:, 1] > spans[:, 0]
    if full.any():
        begin, end = pieces[spans[full, 0], 0], pieces[spans[full, 1] - 1, 1]
        total[full], number[full] = sums[end] - sums[begin], end - begin
    return total, number
