"""TriMesh: triangles over a model's exact surfaces."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import IO, TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _core
from .formats import mesh_format_of
from .importer.errors import UsageError

if TYPE_CHECKING:
    from .model import Model

Float64s = npt.NDArray[np.float64]
Int32s = npt.NDArray[np.int32]
Float32s = npt.NDArray[np.float32]

DEFAULT_DEVIATION = "0.1%"


@dataclass(frozen=True)
class MeshIssue:
    """A face whose trims could not be triangulated as they are. The mesh covers it all the same, but by how
    much it is off is not proven. face: its number."""

    face: int
    reason: str


@dataclass(frozen=True)
class MeshCheck:
    """open_edges: sides of one triangle only. non_manifold_edges: of three or more, or of two that run the
    same way. non_manifold_vertices: whose triangles form more than one fan. degenerate_triangles: without
    height. volume: mm^3, signed; says something where there are no open edges. area: mm^2."""

    open_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    degenerate_triangles: int
    volume: float
    area: float

    @property
    def watertight(self) -> bool:
        """Every side of a triangle is the side of exactly one other, turned round."""
        return self.open_edges == 0 and self.non_manifold_edges == 0


@dataclass(frozen=True, eq=False)
class TriMesh:
    """Triangles in the world, counter-clockwise seen from outside. Every place of a part has its own.

    vertices: (n, 3) float64, mm. triangles: (m, 3) int32 into vertices. corner_uv: (m, 3, 2) float64,
    parameters of the face's surface at each corner. face, instance: (m,) int32, numbers in ``model.faces``
    and ``model.instances``. deviation: (m,) float64, mm, proven: no point of the triangle is farther from
    its surface, nor the other way round; inf where nothing is proven (see issues), 0 for faces that are
    triangles themselves. issues: faces that could not be meshed as they are. asked: mm; nan of a mesh for a
    camera, of which asked_px is the deviation asked for, in px.
    """

    vertices: Float64s
    triangles: Int32s
    corner_uv: Float64s
    face: Int32s
    instance: Int32s
    deviation: Float64s
    issues: tuple[MeshIssue, ...]
    asked: float
    asked_px: float | None
    _model: Model
    _pieces: tuple[Piece, ...]  # what the mesh is made of, in its order

    def __repr__(self) -> str:
        return f"<TriMesh: {len(self.triangles)} triangles, {len(self.vertices)} vertices>"

    def check(self) -> MeshCheck:
        """Counts what keeps the mesh from being closed and sound."""
        return MeshCheck(**_core.check_mesh(self.vertices, self.triangles))

    def normals(self, threads: int = 0) -> Float64s:
        """(m, 3, 3) float64: the exact surface's outward unit normal at each corner."""
        parts = {id(p.part): p.part for p in self._pieces}
        known = {key: part.normals(self._model._core, threads) for key, part in parts.items()}
        placed = []
        for piece in self._pieces:
            normals = known[id(piece.part)] @ np.linalg.inv(piece.placed.linear)
            length = np.linalg.norm(normals, axis=-1, keepdims=True)
            normals /= np.where(length > 0.0, length, 1.0)
            placed.append(normals[:, ::-1] if piece.placed.mirrored else normals)
        return np.concatenate(placed) if placed else np.empty((0, 3, 3))

    def save(self, path: str | os.PathLike[str] | IO[bytes], *, format: str | None = None) -> None:
        """Writes the mesh: stl and ply (binary), obj, off, in mm; glb in metres with Y up, as glTF demands.

        path: a file, or an open binary stream. format: by default the one of the path's extension. ply, off
        and glb hold the colours, glb the normals and the names of the parts too. Coordinates are float32 in
        all of them. The file appears whole or not at all; equal meshes give equal bytes. Raises OutputError,
        UsageError.
        """
        from . import mesh_files
        from .image_io import write_file

        if not isinstance(path, str | os.PathLike):
            path.write(mesh_files.encode(self, mesh_format_of("", format or "stl")))
            return
        data = mesh_files.encode(self, mesh_format_of(path, format))
        write_file(os.fspath(path), data)


@dataclass(frozen=True)
class Part:
    """The mesh of one prototype, in its own coordinates."""

    vertices: Float64s
    triangles: Int32s
    corner_uv: Float64s
    face: Int32s
    deviation: Float64s

    def normals(self, store: _core.Store, threads: int = 0) -> Float64s:
        return _core.corner_normals(store, self.vertices, self.triangles, self.corner_uv, self.face, threads)


@dataclass(frozen=True)
class Placed:
    """An instance as numbers. linear, shift: part to world, world = linear @ p + shift."""

    part: int
    linear: Float64s
    shift: Float64s

    @property
    def mirrored(self) -> bool:
        return bool(np.linalg.det(self.linear) < 0.0)

    @property
    def scale(self) -> float:
        """By how much it stretches lengths at most."""
        return float(np.linalg.norm(self.linear, 2))


@dataclass(frozen=True)
class Piece:
    """The mesh of an instance. part: shared by the instances that have the same one."""

    instance: int
    placed: Placed
    part: Part


def placed(model: Model) -> list[Placed]:
    parts = model._core.instance_prototypes().tolist()
    placements = model._core.instance_placements()
    return [Placed(p, m[:, :3], m[:, 3]) for p, m in zip(parts, placements, strict=True)]


def parse_deviation(deviation: float | str | None) -> tuple[float, str]:
    """(number, unit) with unit "mm", "%" or "px": of 2, "2", "2mm", "2 %", "0.3px". Raises UsageError."""
    text = DEFAULT_DEVIATION if deviation is None else str(deviation).strip().lower()
    unit = next((u for u in ("mm", "%", "px") if text.endswith(u)), "")
    try:
        number = float(text.removesuffix(unit))
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise UsageError(f"deviation: '{deviation}' is not a positive length such as 0.05mm, 0.1% or 0.3px")
    return number, unit or "mm"


def tessellate(
    model: Model,
    deviation: float | str | None,
    angle: float | None,
    threads: int,
    progress: Callable[[str, float | None], None] | None,
) -> TriMesh:
    """Model.tessellate."""
    number, unit = parse_deviation(deviation)
    if unit == "px":
        raise UsageError(f"deviation: '{deviation}': pixels need a view")
    if angle is not None and not angle > 0.0:
        raise UsageError(f"angle: {angle} is not a positive angle")
    low, high = model.bounds  # raises when there is nothing to mesh
    asked = number if unit == "mm" else number / 100.0 * float(np.linalg.norm(high - low))
    if not asked > 0.0:
        raise UsageError("deviation: the model has no size to take a share of; give it in mm")
    instances = placed(model)
    scales: dict[int, float] = {}
    for instance in instances:
        scales[instance.part] = max(scales.get(instance.part, 0.0), instance.scale)
    parts: dict[int, Part] = {}
    issues: list[MeshIssue] = []
    for done, (part, scale) in enumerate(scales.items()):
        if progress is not None:
            progress("mesh", done / len(scales))
        arrays, found = _core.tessellate(
            model._core,
            part,
            asked / max(scale, 1e-300),
            math.inf if angle is None else float(angle),
            threads,
        )
        parts[part] = Part(*arrays)
        issues += [MeshIssue(face, reason) for face, reason in found]
    pieces = tuple(Piece(k, instance, parts[instance.part]) for k, instance in enumerate(instances))
    return place(model, pieces, issues, asked)


def place(
    model: Model,
    pieces: tuple[Piece, ...],
    issues: Iterable[MeshIssue],
    asked: float,
    asked_px: float | None = None,
) -> TriMesh:
    """Every instance's mesh at its place, in their order; mirrored ones turned round."""
    vertices: list[Float64s] = [np.empty((0, 3))]
    triangles: list[Int32s] = [np.empty((0, 3), np.int32)]
    uv: list[Float64s] = [np.empty((0, 3, 2))]
    count = 0
    for piece in pieces:
        part = piece.part
        corners, corner_uv = part.triangles, part.corner_uv
        if piece.placed.mirrored:
            corners, corner_uv = corners[:, ::-1], corner_uv[:, ::-1]
        if count + len(part.vertices) > np.iinfo(np.int32).max:
            raise UsageError("the mesh has too many vertices: ask for a larger deviation")
        triangles.append((corners + count).astype(np.int32))
        vertices.append(part.vertices @ piece.placed.linear.T + piece.placed.shift)
        uv.append(corner_uv)
        count += len(part.vertices)
    sizes = [len(p.part.triangles) for p in pieces]
    faces = [np.empty(0, np.int32), *(p.part.face for p in pieces)]
    deviations = [np.empty(0), *(p.part.deviation * p.placed.scale for p in pieces)]
    return TriMesh(
        vertices=np.ascontiguousarray(np.concatenate(vertices)),
        triangles=np.ascontiguousarray(np.concatenate(triangles)),
        corner_uv=np.ascontiguousarray(np.concatenate(uv)),
        face=np.concatenate(faces),
        instance=np.repeat(np.array([p.instance for p in pieces], np.int32), sizes),
        deviation=np.concatenate(deviations),
        issues=tuple(sorted(set(issues), key=lambda i: (i.face, i.reason))),
        asked=asked,
        asked_px=asked_px,
        _model=model,
        _pieces=pieces,
    )
