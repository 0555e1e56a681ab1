"""OpenCascade's mesh (BRepMesh) of the shapes that trimray's store is built from, for comparison.

    python -m tests.verify.brep_mesh FILE OUT_FOLDER DEFLECTION...

is the child: it imports FILE, rebuilds the importer's shapes and meshes them at each deflection (mm), since
OpenCascade may crash or hang doing so. ``brep_meshes`` runs it with limits.
"""

from __future__ import annotations

import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

ANGLE = 0.5  # rad, BRepMesh's default
MEMORY = 12 << 30  # bytes


@dataclass
class BrepMesh:
    """One prototype. Vertices are merged where the shape shares edges and vertices. face: position of the
    face in the prototype; shapes: of every face, its 1-based place in the importer's stream."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    corner_uv: NDArray[np.float64]
    face: NDArray[np.int32]
    shapes: NDArray[np.int32]
    volume: float  # mm^3, of the exact shape (BRepGProp)


@dataclass
class BrepMeshes:
    prototypes: list[BrepMesh]
    seconds: float  # of the first meshing
    missing: int  # faces without triangles


def _limit_memory() -> None:
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = MEMORY if hard == resource.RLIM_INFINITY else min(MEMORY, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def brep_meshes(file: Path, deflections: list[float], time_limit: float) -> list[BrepMeshes | str]:
    """BRepMesh of the file's prototypes at each deflection (mm), or why there is none."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "tests.verify.brep_mesh", str(file), folder, *map(repr, deflections)]
        try:
            done = subprocess.run(
                command,
                timeout=time_limit,
                capture_output=True,
                text=True,
                check=False,
                preexec_fn=_limit_memory,
                cwd=Path(__file__).resolve().parents[2],
            )
            lines = done.stderr.strip().splitlines()
            why = f"signal {-done.returncode}" if done.returncode < 0 else (lines or ["?"])[-1]
        except subprocess.TimeoutExpired:
            why = f"over {time_limit:g} s"
        return [_result(Path(folder) / str(k), why) for k in range(len(deflections))]


def _result(folder: Path, why: str) -> BrepMeshes | str:
    if not (folder / "done.json").is_file():
        return why
    facts = json.loads((folder / "done.json").read_text())
    prototypes = []
    for k, volume in enumerate(facts["volumes"]):
        with np.load(folder / f"{k}.npz") as a:
            prototypes.append(BrepMesh(**{name: a[name] for name in a.files}, volume=volume))
    return BrepMeshes(prototypes, facts["seconds"], facts["missing"])


def read_shapes(file: Path) -> tuple[Any, list[Any]]:
    """The importer's shapes: the set that numbers them, and the root of every prototype."""
    from OCP.BinTools import BinTools_ShapeSet

    from trimray.importer import read_model

    model = read_model(file)
    shapes = BinTools_ShapeSet()
    shapes.Read(io.BytesIO(model.brep))
    return shapes, [shapes.Shape(int(i)) for i in model.prototype_shapes]


def mesh_shapes(roots: list[Any], deflection: float) -> float:
    """Meshes all prototypes anew, in parallel as far as BRepMesh can. Returns seconds."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepTools import BRepTools

    for root in roots:
        BRepTools.Clean_s(root, True)
    start = time.perf_counter()
    for root in roots:
        BRepMesh_IncrementalMesh(root, deflection, False, ANGLE, True)
    return time.perf_counter() - start


class _Merge:
    """Nodes of all faces of one shape, united where edges and vertices are shared."""

    def __init__(self, root: Any, shapes: Any) -> None:
        from OCP.BRep import BRep_Tool
        from OCP.TopAbs import TopAbs_ShapeEnum
        from OCP.TopExp import TopExp_Explorer
        from OCP.TopLoc import TopLoc_Location
        from OCP.TopoDS import TopoDS
        from OCP.TopTools import TopTools_IndexedMapOfShape

        self.parent: list[int] = []
        self.points: list[tuple[float, float, float]] = []
        self.triangles: list[tuple[int, int, int]] = []
        self.uv: list[tuple[float, float]] = []
        self.face: list[int] = []
        self.shapes: list[int] = []
        self.missing = 0
        self._same = TopTools_IndexedMapOfShape()  # one number a shape and place, either way round
        self._edges: dict[int, list[int]] = {}
        self._vertices: dict[int, int] = {}
        explorer = TopExp_Explorer(root, TopAbs_ShapeEnum.TopAbs_FACE)
        while explorer.More():
            face = TopoDS.Face_s(explorer.Current())
            self.shapes.append(shapes.Index(face.Located(TopLoc_Location())))
            location = TopLoc_Location()
            mesh = BRep_Tool.Triangulation_s(face, location)
            if mesh is None:
                self.missing += 1
            else:
                self._add(face, mesh, location)
            explorer.Next()

    def root(self, i: int) -> int:
        while self.parent[i] != i:
            self.parent[i] = self.parent[self.parent[i]]
            i = self.parent[i]
        return i

    def unite(self, a: int, b: int) -> None:
        a, b = self.root(a), self.root(b)
        self.parent[max(a, b)] = min(a, b)

    def _add(self, face: Any, mesh: Any, location: Any) -> None:
        from OCP.BRep import BRep_Tool
        from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
        from OCP.TopExp import TopExp, TopExp_Explorer
        from OCP.TopoDS import TopoDS

        first = len(self.points)
        transform = location.Transformation()
        for i in range(1, mesh.NbNodes() + 1):
            p = mesh.Node(i).Transformed(transform)
            self.points.append((p.X(), p.Y(), p.Z()))
            uv = mesh.UVNode(i) if mesh.HasUVNodes() else None
            self.uv.append((uv.X(), uv.Y()) if uv is not None else (np.nan, np.nan))
            self.parent.append(first + i - 1)
        turned = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        for i in range(1, mesh.NbTriangles() + 1):
            t = mesh.Triangle(i)
            a, b, c = (first + t.Value(k) - 1 for k in (1, 2, 3))
            self.triangles.append((a, c, b) if turned else (a, b, c))
        self.face += [len(self.shapes) - 1] * mesh.NbTriangles()
        explorer = TopExp_Explorer(face, TopAbs_ShapeEnum.TopAbs_EDGE)
        while explorer.More():
            edge = TopoDS.Edge_s(explorer.Current())
            polygon = BRep_Tool.PolygonOnTriangulation_s(edge, mesh, location)
            if polygon is not None:
                nodes = [first + polygon.Node(i) - 1 for i in range(1, polygon.NbNodes() + 1)]
                if BRep_Tool.Degenerated_s(edge):
                    for n in nodes[1:]:
                        self.unite(nodes[0], n)
                else:
                    known = self._edges.setdefault(self._same.Add(edge), nodes)
                    for a, b in zip(known, nodes, strict=False):
                        self.unite(a, b)
                for vertex, node in (
                    (TopExp.FirstVertex_s(edge), nodes[0]),
                    (TopExp.LastVertex_s(edge), nodes[-1]),
                ):
                    if not vertex.IsNull():
                        self.unite(self._vertices.setdefault(self._same.Add(vertex), node), node)
            explorer.Next()

    def arrays(self) -> dict[str, NDArray[Any]]:
        roots = np.array([self.root(i) for i in range(len(self.parent))], np.int64)
        used, merged = np.unique(roots, return_inverse=True)
        triangles = np.array(self.triangles, np.int64).reshape(-1, 3)
        return {
            "vertices": np.array(self.points, np.float64).reshape(-1, 3)[used],
            "triangles": merged[triangles].astype(np.int32),
            "corner_uv": np.array(self.uv, np.float64).reshape(-1, 2)[triangles],
            "face": np.array(self.face, np.int32),
            "shapes": np.array(self.shapes, np.int32),
        }


def _volume(root: Any) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    props = GProp_GProps()
    BRepGProp.VolumeProperties_s(root, props)
    return float(props.Mass())


def main(file: str, folder: str, deflections: list[float]) -> None:
    shapes, roots = read_shapes(Path(file))
    volumes = [_volume(root) for root in roots]
    for k, deflection in enumerate(deflections):
        seconds = mesh_shapes(roots, deflection)
        out, missing = Path(folder) / str(k), 0
        out.mkdir()
        for n, root in enumerate(roots):
            merged = _Merge(root, shapes)
            missing += merged.missing
            np.savez(out / f"{n}.npz", **merged.arrays())  # type: ignore[arg-type]
        facts = {"seconds": seconds, "missing": missing, "volumes": volumes}
        (out / "done.json").write_text(json.dumps(facts))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], [float(x) for x in sys.argv[3:]])
    sys.stdout.flush()
    os._exit(0)  # freeing the shapes takes longer than meshing them
