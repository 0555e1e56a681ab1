"""TriMesh: triangles over a model's exact surfaces."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
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
    triangles themselves. issues: faces that could not be meshed as they are. asked: mm.
    """

    vertices: Float64s
    triangles: Int32s
    corner_uv: Float64s
    face: Int32s
    instance: Int32s
    deviation: Float64s
    issues: tuple[MeshIssue, ...]
    asked: float
    _model: Model
    _parts: dict[int, Part]  # by prototype: the mesh where the part itself stands

    def __repr__(self) -> str:
        return f"<TriMesh: {len(self.triangles)} triangles, {len(self.vertices)} vertices>"

    def check(self) -> MeshCheck:
        """Counts what keeps the mesh from being closed and sound."""
        return MeshCheck(**_core.check_mesh(self.vertices, self.triangles))

    def normals(self, threads: int = 0) -> Float64s:
        """(m, 3, 3) float64: the exact surface's outward unit normal at each corner."""
        parts = {p: part.normals(self._model._core, threads) for p, part in self._parts.items()}
        placed = []
        for instance in _placed(self._model):
            normals = parts[instance.part] @ np.linalg.inv(instance.linear)
            length = np.linalg.norm(normals, axis=-1, keepdims=True)
            normals /= np.where(length > 0.0, length, 1.0)
            placed.append(normals[:, ::-1] if instance.mirrored else normals)
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


def _placed(model: Model) -> list[Placed]:
    parts = model._core.instance_prototypes().tolist()
    placements = model._core.instance_placements()
    return [Placed(p, m[:, :3], m[:, 3]) for p, m in zip(parts, placements, strict=True)]


def parse_deviation(deviation: float | str | None) -> tuple[float, str]:
    """(number, unit) with unit "mm" or "%": of 2, "2", "2mm", "2 %". Raises UsageError."""
    text = DEFAULT_DEVIATION if deviation is None else str(deviation).strip().lower()
    unit = next((u for u in ("mm", "%", "px") if text.endswith(u)), "")
    try:
        number = float(text.removesuffix(unit))
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise UsageError(f"deviation: '{deviation}' is not a positive length such as 0.05mm or 0.1%")
    if unit == "px":
        raise UsageError(f"deviation: '{deviation}': pixels need a camera, which a mesh does not have yet")
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
    if angle is not None and not angle > 0.0:
        raise UsageError(f"angle: {angle} is not a positive angle")
    low, high = model.bounds  # raises when there is nothing to mesh
    asked = number if unit == "mm" else number / 100.0 * float(np.linalg.norm(high - low))
    if not asked > 0.0:
        raise UsageError("deviation: the model has no size to take a share of; give it in mm")
    instances = _placed(model)
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
    return _place(model, parts, instances, tuple(sorted(issues, key=lambda i: i.face)), asked)


def _place(
    model: Model,
    parts: dict[int, Part],
    instances: list[Placed],
    issues: tuple[MeshIssue, ...],
    asked: float,
) -> TriMesh:
    """Every instance's mesh at its place, in the order of their numbers; mirrored ones turned round."""
    vertices: list[Float64s] = [np.empty((0, 3))]
    triangles: list[Int32s] = [np.empty((0, 3), np.int32)]
    uv: list[Float64s] = [np.empty((0, 3, 2))]
    count = 0
    for instance in instances:
        part = parts[instance.part]
        corners, corner_uv = part.triangles, part.corner_uv
        if instance.mirrored:
            corners, corner_uv = corners[:, ::-1], corner_uv[:, ::-1]
        if count + len(part.vertices) > np.iinfo(np.int32).max:
            raise UsageError("the mesh has too many vertices: ask for a larger deviation")
        triangles.append((corners + count).astype(np.int32))
        vertices.append(part.vertices @ instance.linear.T + instance.shift)
        uv.append(corner_uv)
        count += len(part.vertices)
    sizes = [len(parts[i.part].triangles) for i in instances]
    faces = [np.empty(0, np.int32), *(parts[i.part].face for i in instances)]
    deviations = [np.empty(0), *(parts[i.part].deviation * i.scale for i in instances)]
    return TriMesh(
        vertices=np.ascontiguousarray(np.concatenate(vertices)),
        triangles=np.ascontiguousarray(np.concatenate(triangles)),
        corner_uv=np.ascontiguousarray(np.concatenate(uv)),
        face=np.concatenate(faces),
        instance=np.repeat(np.arange(len(instances), dtype=np.int32), sizes),
        deviation=np.concatenate(deviations),
        issues=issues,
        asked=asked,
        _model=model,
        _parts=parts,
    )
