"""Distances from points to models: points/s a core beside BRepExtrema on the same points, in one run.

`scripts/bench distance [MODEL ...]`. "on" are samples of the model's own faces, moved off them by up to 1e-4
of the diagonal; "far" are random points of the bounds' box, twice as large. Seconds are processor time of
this process, so that other work on the machine does not count; loading and indexing do not count either.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import trimray

FEW = 30  # points that OpenCascade is asked for: a point may take it a tenth of a second


def opencascade(path: Path, points: np.ndarray) -> tuple[np.ndarray, float]:
    """Its distances from the faces, and its points/s."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS_Compound

    from tests.verify.opencascade import read_shape

    faces = TopoDS_Compound()  # without solids, inside of which its distance would be 0
    builder = BRep_Builder()
    builder.MakeCompound(faces)
    explorer = TopExp_Explorer(read_shape(path), TopAbs_FACE)  # type: ignore[arg-type]
    while explorer.More():
        builder.Add(faces, explorer.Current())
        explorer.Next()
    found = np.empty(len(points))
    start = time.process_time()
    for i, p in enumerate(points):
        found[i] = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex(), faces).Value()
    return found, len(points) / (time.process_time() - start)


def bench(path: Path) -> None:
    model = trimray.load(path)
    low, high = model.bounds
    diagonal = float(np.linalg.norm(high - low))
    start = time.process_time()
    model.distance(low)
    index = time.process_time() - start
    random = np.random.default_rng(1)
    samples = model.sample(max(4, 20000 // (len(model.faces) * len(model.instances))), seed=1)
    near = samples.point + samples.normal * random.uniform(-1e-4, 1e-4, (len(samples), 1)) * diagonal
    far = random.uniform(low - (high - low) / 2, high + (high - low) / 2, (2000, 3))
    print(f"{path.name}: {len(model.faces)} faces, index {index:.2f} s")
    for name, points in (("on", near), ("far", far)):
        start = time.process_time()
        found = model.distance(points, threads=1)
        speed = len(points) / (time.process_time() - start)
        few = random.choice(len(points), min(FEW, len(points)), replace=False)
        theirs, slow = opencascade(path, points[few])
        ours = found.distance[few]
        same = np.abs(theirs - ours) <= 1e-6 * diagonal
        print(
            f"  {name:3s}: {speed:10,.0f} points/s a core, OpenCascade {slow:8,.1f}, {speed / slow:9,.0f} x; "
            f"of {len(few)}: same {same.sum()}, we nearer {(~same & (ours < theirs)).sum()}, "
            f"OpenCascade nearer {(~same & (theirs < ours)).sum()}; given up {int((found.gap > 0).sum())}"
        )


def main(arguments: list[str], models: Path) -> None:
    names = arguments or [
        "yuechen-li-dev+Aetheris/nist_ctc_01_asme1_ap242-e1.stp",
        "yuechen-li-dev+Aetheris/nist_stc_06_asme1_ap242-e3.stp",
        "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
        "derived/utah_teapot_32patches.step",
    ]
    for name in names:
        bench(models / name)
        sys.stdout.flush()
