"""The mesh of a model, judged: is it closed and manifold, and is it where it says it is?

Nothing here trusts the tessellator's own bounds: edges are counted, distances measured at many points of
triangles, surfaces and model edges (core/tess/mesh_measure.h, edge_measure.h), volumes compared with
OpenCascade's integrals over the exact shape. BRepMesh's mesh of the very same shapes goes through the same
hands.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trimray
from trimray import _core

from .brep_mesh import BrepMesh, BrepMeshes, brep_meshes

ROUNDING = 1e-12  # of the prototype's diagonal
VOLUME_ROUNDING = 1e-6  # relative, of OpenCascade's integral


@dataclass
class Mesh:
    """One prototype's mesh. deviation: proven, (m,), or None where nothing is claimed."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    corner_uv: NDArray[np.float64]
    face: NDArray[np.int32]
    deviation: NDArray[np.float64] | None = None
    issues: list[tuple[int, str]] = field(default_factory=list)


@dataclass
class Judgement:
    """Sums over the prototypes of a model."""

    triangles: int = 0
    seconds: float = 0.0
    issues: int = 0  # faces covered by other means, and (BRepMesh) faces without triangles
    # Of the triangles of closed shells alone:
    open: int = 0
    non_manifold: int = 0
    non_manifold_vertices: int = 0
    # Of all triangles:
    degenerate: int = 0
    holes: int = 0  # open sides that do not lie on an edge which the model uses once
    off_edges: int = 0  # sides where a face's mesh ends that lie on no edge of it
    skipped: int = 0  # edges of which the mesh leaves out more than the deviation
    turned_over: int = 0  # triangles upside down in uv
    volume: float = 0.0  # worst |volume - exact| / (deviation * area) of closed prototypes: at most 1
    negative: int = 0  # closed prototypes of positive volume whose mesh has none
    over_request: int = 0  # triangles proven to less than was asked for
    measured: int = 0  # triangles
    worst_request: float = 0.0  # measured deviation / requested
    worst_back: float = 0.0  # measured distance of the surface from the face's triangles / requested
    worst_edge: float = 0.0  # measured distance between sides and edges, either way / requested
    worst_proven: float = 0.0  # measured deviation / proven
    violations: int = 0  # triangles farther from their surface than proven
    edge_violations: int = 0  # sides farther from their edge than proven for the triangles beside them
    notes: list[str] = field(default_factory=list)

    @property
    def wrong(self) -> int:
        """What a mesh that keeps its promises has none of."""
        return (
            self.open + self.non_manifold + self.degenerate + self.holes + self.off_edges + self.skipped
            + self.turned_over + (self.volume > 1.0) + self.negative + self.over_request + self.violations
            + self.edge_violations
        )  # fmt: skip


def diagonal(model: trimray.Model) -> float:
    low, high = model.bounds
    return float(np.linalg.norm(high - low))


def tessellate(model: trimray.Model, deviation: float, threads: int = 0) -> tuple[list[Mesh], float]:
    """Our mesh of every prototype, and the seconds it took."""
    meshes = []
    seconds = 0.0
    for prototype in range(len(model._core.prototype_faces())):
        start = time.perf_counter()
        arrays, issues = _core.tessellate(model._core, prototype, deviation, float("inf"), threads)
        seconds += time.perf_counter() - start
        meshes.append(Mesh(*arrays, issues=issues))
    return meshes, seconds


def judge(
    model: trimray.Model,
    meshes: list[Mesh],
    volumes: list[float],
    deviation: float,
    most_triangles: int = 20000,
) -> Judgement:
    """meshes, volumes (exact, mm^3; NaN: unknown): by prototype. deviation: requested, mm."""
    store = model._core
    result = Judgement()
    closed_faces, edge_uses = _core.closed_faces(store), _core.edge_uses(store)
    ranges = store.prototype_faces().tolist()
    statuses = np.array([s == "ok" for s in store.face_statuses()])
    for (begin, end), mesh, volume in zip(ranges, meshes, volumes, strict=True):
        result.triangles += len(mesh.triangles)
        result.issues += len(mesh.issues)
        drawn = np.zeros(store.face_count, bool)
        drawn[mesh.face] = True
        for face in np.flatnonzero(~drawn[begin:end] & statuses[begin:end]) + begin:
            if not any(face == f for f, _ in mesh.issues):
                result.issues += 1
                result.notes.append(f"face {face} has no triangles")
        if len(mesh.triangles) == 0:
            continue
        closed = closed_faces[mesh.face].astype(bool)
        part = _core.check_mesh(mesh.vertices, np.ascontiguousarray(mesh.triangles[closed]))
        whole = _core.check_mesh(mesh.vertices, mesh.triangles)
        result.open += part["open_edges"]
        result.non_manifold += part["non_manifold_edges"]
        result.non_manifold_vertices += part["non_manifold_vertices"]
        result.degenerate += whole["degenerate_triangles"]
        if closed.all() and np.isfinite(volume):
            bound = deviation * whole["area"] + VOLUME_ROUNDING * abs(volume)
            # The importer turns shells of triangles outwards, OpenCascade leaves them as they are.
            result.volume = max(result.volume, abs(abs(whole["volume"]) - abs(volume)) / bound)
            result.negative += volume > 0 >= whole["volume"]
        _measure(store, mesh, edge_uses, deviation, most_triangles, result)
    return result


def _measure(
    store: _core.Store,
    mesh: Mesh,
    edge_uses: NDArray[np.int32],
    deviation: float,
    most_triangles: int,
    result: Judgement,
) -> None:
    arrays = (mesh.vertices, mesh.triangles, mesh.corner_uv, mesh.face)
    # Coordinates are rounded by their size, wherever the part lies.
    rounding = ROUNDING * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    rounding = max(rounding, 8 * np.finfo(float).eps * float(np.abs(mesh.vertices).max()))
    proven = mesh.deviation if mesh.deviation is not None else np.full(len(mesh.triangles), deviation)
    measured, back = _core.measure_mesh(store, *arrays, proven, 6, most_triangles)
    known = np.flatnonzero(np.isfinite(measured))
    result.measured += len(known)
    if len(known):
        result.worst_request = max(result.worst_request, float(measured[known].max()) / deviation)
        result.worst_back = max(result.worst_back, float(back[known].max()) / deviation)
    edges = _core.measure_mesh_edges(store, *arrays)
    is_open, edge = edges["open"].astype(bool), edges["edge"]
    apart = np.where(edge >= 0, np.maximum(edges["edge_to_side"], edges["side_to_edge"]), 0.0)
    result.worst_edge = max(result.worst_edge, float(apart.max(initial=0.0)) / deviation)
    once = edge >= 0
    once[once] = edge_uses[edge[once]] == 1
    # Faces of triangles have no edges; where they must close, their open sides are counted above.
    exact = np.array([kind not in ("none", "mesh") for kind in store.face_kinds()])
    has_edges = exact[mesh.face[edges["triangle"]]]
    result.holes += int((is_open & ~once & has_edges).sum())
    if mesh.deviation is None:
        return
    fallback = ~np.isfinite(mesh.deviation)
    result.over_request += int((mesh.deviation[~fallback] > deviation * (1 + 1e-9)).sum())
    known = known[~fallback[known]]
    limit = mesh.deviation * (1 + 1e-9) + rounding
    bad = known[measured[known] > limit[known]]
    result.violations += len(bad)
    for t in bad[:3]:
        result.notes.append(
            f"triangle {t} of face {mesh.face[t]}: measured {measured[t]:.6g}, proven {mesh.deviation[t]:.6g}"
        )
    if len(known):
        result.worst_proven = max(result.worst_proven, float((measured[known] / limit[known]).max()))
    beside = edges["triangle"]
    # An edge is as near as the triangles beside it are proven to be: a plane's own is no measure of its rim.
    allowed = _side_limits(mesh, limit, edges)
    far = (edge >= 0) & (apart > allowed)
    result.edge_violations += int(far.sum())
    for s in np.flatnonzero(far)[:3]:
        result.notes.append(
            f"edge {edge[s]}: {apart[s]:.6g} from a side of triangle {beside[s]} of face "
            f"{mesh.face[beside[s]]}, proven {allowed[s]:.6g}"
        )
    off = (edge < 0) & ~fallback[beside] & has_edges
    result.off_edges += int(off.sum())
    for s in np.flatnonzero(off)[:3]:
        result.notes.append(f"a side of triangle {beside[s]} of face {mesh.face[beside[s]]} lies on no edge")
    skipped = edges["edge_missing"] > deviation + rounding
    covered_otherwise = np.isin(np.arange(len(skipped)), [e for e in edge[fallback[beside]] if e >= 0])
    result.skipped += int((skipped & ~covered_otherwise).sum())
    for e in np.flatnonzero(skipped & ~covered_otherwise)[:3]:
        result.notes.append(
            f"edge {e}: {edges['edge_missing'][e]:.6g} of {edges['edge_length'][e]:.6g} mm have no side"
        )
    cover = _core.measure_mesh_cover(store, *arrays)["turned_over"]
    faces = np.flatnonzero((cover > 0) & exact & ~np.isin(np.arange(len(cover)), mesh.face[fallback]))
    result.turned_over += int(cover[faces].sum())
    result.notes += [f"face {f}: {cover[f]} triangles upside down in uv" for f in faces[:3]]


def _side_limits(mesh: Mesh, limit: NDArray[np.float64], edges: dict[str, Any]) -> NDArray[np.float64]:
    """By border side: the largest limit of the triangles that have it."""
    t, corner = edges["triangle"], edges["corner"]
    ends = np.sort(np.stack([mesh.triangles[t, corner], mesh.triangles[t, (corner + 1) % 3]], axis=1), axis=1)
    _, number = np.unique(ends, axis=0, return_inverse=True)
    largest = np.zeros(len(ends))
    np.maximum.at(largest, number.ravel(), limit[t])
    return np.asarray(largest[number.ravel()])


def check_ours(
    model: trimray.Model, volumes: list[float], deviation: float, most_triangles: int = 20000
) -> Judgement:
    meshes, seconds = tessellate(model, deviation)
    result = judge(model, meshes, volumes, deviation, most_triangles)
    result.seconds = seconds
    for mesh in meshes:
        result.notes += [f"face {face}: {reason}" for face, reason in mesh.issues[:3]]
    return result


def as_mesh(model: trimray.Model, prototype: int, brep: BrepMesh) -> Mesh:
    """BRepMesh's mesh with the store's face numbers. Raises ValueError where they cannot be told."""
    begin, end = model._core.prototype_faces()[prototype].tolist()
    if not np.array_equal(brep.shapes, model._core.face_shapes()[begin:end]):
        raise ValueError("the faces stand in another order")
    uv = np.ascontiguousarray(np.nan_to_num(brep.corner_uv))
    return Mesh(brep.vertices, brep.triangles, uv, (brep.face + begin).astype(np.int32))


def check_theirs(
    model: trimray.Model, brep: BrepMeshes, deviation: float, most_triangles: int = 20000
) -> Judgement:
    meshes = [as_mesh(model, k, p) for k, p in enumerate(brep.prototypes)]
    result = judge(model, meshes, [p.volume for p in brep.prototypes], deviation, most_triangles)
    result.seconds = brep.seconds
    return result


def check(
    file: Path, model: trimray.Model, fractions: list[float], time_limit: float, most_triangles: int = 20000
) -> list[tuple[float, Judgement | str, Judgement | str]]:
    """By fraction of the model's diagonal: ours and BRepMesh's, or why there is none."""
    size = diagonal(model)
    breps = brep_meshes(file, [f * size for f in fractions], time_limit)
    unknown = [float("nan")] * len(model._core.prototype_faces())
    volumes = next(([p.volume for p in b.prototypes] for b in breps if not isinstance(b, str)), unknown)
    rows: list[tuple[float, Judgement | str, Judgement | str]] = []
    for fraction, brep in zip(fractions, breps, strict=True):
        deviation = fraction * size
        theirs: Judgement | str
        if isinstance(brep, str):
            theirs = brep
        else:
            try:
                theirs = check_theirs(model, brep, deviation, most_triangles)
            except ValueError as error:
                theirs = str(error)
        rows.append((fraction, check_ours(model, volumes, deviation, most_triangles), theirs))
    return rows


HEADER = (
    f"{'model':44} {'of':4} {'deviation':>9} {'triangles':>9} {'s':>7} {'open':>5} {'nonm.':>5} "
    f"{'degen.':>6} {'holes':>5} {'volume':>7} {'faces':>5} {'/asked':>7} {'back':>7} {'edges':>7} "
    f"{'/proven':>7} {'wrong':>5}"
)


def line(name: str, who: str, fraction: float, j: Judgement | str) -> str:
    start = f"{name:44.44} {who:4} {fraction:9.0e} "
    if isinstance(j, str):
        return start + j
    return start + (
        f"{j.triangles:9} {j.seconds:7.3f} {j.open:5} {j.non_manifold:5} {j.degenerate:6} {j.holes:5} "
        f"{j.volume:7.3f} {j.issues:5} {j.worst_request:7.3f} {j.worst_back:7.3f} {j.worst_edge:7.3f} "
        + (f"{j.worst_proven:7.3f} {j.wrong:5}" if who == "ours" else "")
    )
