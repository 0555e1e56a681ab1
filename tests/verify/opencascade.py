"""OpenCascade's own ray caster on the same rays, its disagreements classified with the reference's help.

OpenCascade is no oracle: it drops one of two close roots and decides at edges by their tolerance. Where
it differs from us the reference tracer is asked; a disagreement in which the reference sides with
OpenCascade is a bug of ours.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

import trimray

from .reference import EDGE_ON, picture_rays


def read_shape(path: Path) -> object:
    """The file's shape as OpenCascade reads it, in this process."""
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    reader = IGESControl_Reader() if path.suffix.lower() in (".igs", ".iges") else STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader.OneShape()


def check(path: Path, n: int) -> Counter[str]:
    """Classes of 26 n rays: agree, in face, edge (within a shape tolerance), occt wrong, ours wrong."""
    from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
    from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

    shape = read_shape(path)
    model = trimray.load(shape, cache=False)
    intersector = IntCurvesFace_ShapeIntersector()
    intersector.Load(shape, 1e-9)
    origins, directions = picture_rays(model, n)
    hits = model.cast(origins, directions)
    flat = (hits.face >= 0) & (np.abs((hits.normal * directions).sum(axis=1)) < EDGE_ON)
    low, high = model.bounds
    diagonal = float(np.linalg.norm(high - low))
    classes: Counter[str] = Counter()
    for o, d, t, in_face in zip(origins, directions, hits.t, flat, strict=True):
        intersector.PerformNearest(gp_Lin(gp_Pnt(*o), gp_Dir(*d)), 0.0, 4 * diagonal)
        theirs = intersector.WParameter(1) if intersector.NbPnt() > 0 else np.inf
        if theirs == t or abs(theirs - t) <= 1e-7 * diagonal:
            classes["agree"] += 1
            continue
        if in_face:
            classes["in face"] += 1  # the ray lies in a plane
            continue
        judge = float(model.cast(o[None], d[None], mode="reference").t[0])
        if judge == t or abs(judge - t) <= 1e-9 * diagonal:
            # Does OpenCascade agree with us a hair beside? Then it decided at an edge by tolerance.
            side = np.cross(d, [0.3, 0.5, 0.8])
            shifts = [s * 1e-4 * diagonal * side for s in (-1, 1)]
            beside = model.cast(np.array([o + s for s in shifts]), np.array([d, d])).t
            edge = any(b == theirs or abs(b - theirs) < 1e-3 * diagonal for b in beside)
            classes["edge" if edge else "occt wrong"] += 1
        elif abs(judge - theirs) <= 1e-7 * diagonal or judge == theirs:
            classes["ours wrong"] += 1
        else:
            classes["all differ"] += 1
    return classes
