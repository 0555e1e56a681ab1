"""The tessellator beside BRepMesh: seconds and triangles at the same deviations, in one run.

Both mesh the same shapes: what the importer gives, BRepMesh in its parallel mode with its default angle
(0.5 rad) and all earlier triangles removed, ours by deviation alone. Every figure is a median; BRepMesh runs
in a child process because it may crash.

    scripts/bench mesh [FILE...] [--deviations 1e-2 1e-3 1e-4]
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import trimray
from trimray import _core

ROOT = Path(__file__).resolve().parents[2]
SET = (
    "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
    "yuechen-li-dev+Aetheris/nist_stc_06_asme1_ap242-e3.stp",
    "AngelLM+Thor/Art2BodyA.step",
    "VoronDesign+Voron-Stealthburner/Bowden_Module.step",
    "derived/tigl_D150_aircraft_mirrored.step",
    "pypi-pyiges/impeller.igs",
    "IEAWindTask37+IEA-15-240-RWT/IEA_15MW_CFD.igs",
    "DLR-SC+tigl/D150WithGuides_wing.igs",
    "Open-Cascade-SAS+OCCT/hammer.iges",
)
DEVIATIONS = (1e-2, 1e-3, 1e-4)


def ours(model: trimray.Model, deviation: float, threads: int, repeat: int) -> tuple[float, int]:
    """Median seconds over all prototypes, and triangles."""
    seconds, triangles = [], 0
    for _ in range(repeat):
        start = time.perf_counter()
        meshes = [
            _core.tessellate(model._core, k, deviation, float("inf"), threads)[0]
            for k in range(len(model._core.prototype_faces()))
        ]
        seconds.append(time.perf_counter() - start)
        triangles = sum(len(mesh[1]) for mesh in meshes)
    return statistics.median(seconds), triangles


def brep_mesh_child(file: Path, deviations: list[float], repeat: int, time_limit: float) -> list[Any]:
    """[seconds, triangles, faces without triangles] by deviation (mm); fewer when it dies."""
    command = [sys.executable, "-m", __name__, str(file), str(repeat), *map(repr, deviations)]
    try:
        done = subprocess.run(
            command, timeout=time_limit, capture_output=True, text=True, check=False, cwd=ROOT
        )
        out = done.stdout
    except subprocess.TimeoutExpired as error:
        out = error.stdout.decode() if isinstance(error.stdout, bytes) else (error.stdout or "")
    return [json.loads(line) for line in out.splitlines() if line.startswith("[")]


def _child(file: str, repeat: int, deviations: list[float]) -> None:
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    from tests.verify.brep_mesh import mesh_shapes, read_shapes

    _, roots = read_shapes(Path(file))
    for deviation in deviations:
        seconds = statistics.median(mesh_shapes(roots, deviation) for _ in range(repeat))
        triangles = missing = 0
        for root in roots:
            explorer = TopExp_Explorer(root, TopAbs_ShapeEnum.TopAbs_FACE)
            while explorer.More():
                mesh = BRep_Tool.Triangulation_s(TopoDS.Face_s(explorer.Current()), TopLoc_Location())
                triangles += mesh.NbTriangles() if mesh is not None else 0
                missing += mesh is None
                explorer.Next()
        print(json.dumps([seconds, triangles, missing]), flush=True)
    os._exit(0)


def table(files: list[Path], deviations: list[float], repeat: int, time_limit: float) -> None:
    print(
        f"{'model':36} {'deviation':>9} {'ours s':>8} {'1 thread':>8} {'BRepMesh':>8} {'ratio':>6} "
        f"{'triangles':>9} {'BRepMesh':>9} {'ratio':>6} {'lost':>5}"
    )
    for file in files:
        model = trimray.load(file)
        low, high = model.bounds
        size = float(np.linalg.norm(high - low))
        theirs = brep_mesh_child(file, [f * size for f in deviations], repeat, time_limit)
        for k, fraction in enumerate(deviations):
            two, triangles = ours(model, fraction * size, 0, repeat)
            one, _ = ours(model, fraction * size, 1, repeat)
            line = f"{file.name:36} {fraction:9.0e} {two:8.3f} {one:8.3f} "
            if k < len(theirs):
                seconds, count, lost = theirs[k]
                line += f"{seconds:8.3f} {two / seconds:6.2f} {triangles:9} {count:9} "
                line += f"{triangles / count:6.2f} {lost:5}"
            else:
                line += f"{'died':>8} {'':6} {triangles:9}"
            print(line, flush=True)


if __name__ == "__main__":
    _child(sys.argv[1], int(sys.argv[2]), [float(x) for x in sys.argv[3:]])
