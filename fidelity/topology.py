"""What a model consists of, counted in the world: a part placed twice counts twice.

Bezier and B-spline faces are one kind: files do not tell them apart. Shells count with their faces; a vertex
or an edge counts for each part that has it. An open shell of one face is that face: STEP knows no other way
to write one that is in no shell.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import partial

import numpy as np

from .findings import count
from .parts import kind_families
from .record import Finding
from .side import Side

_count = partial(count, "topology")
# Of these one model can lack some; the other numbers may just change.
_THINGS = ("solids", "shells", "faces")


def compare_topology(a: Side, b: Side) -> list[Finding]:
    counts = counts_of(a), counts_of(b)
    findings = [_count(name, [c[name] for c in counts]) for name in counts[0]]
    findings = [f if f.name in _THINGS else replace(f, missing=False) for f in findings]
    kinds = kinds_of(a), kinds_of(b)
    findings += [
        replace(_count(f"faces of kind {kind}", [k[kind] for k in kinds]), missing=False)
        for kind in sorted(kinds[0] | kinds[1])
    ]
    return findings


def kinds_of(side: Side) -> Counter[str]:
    weights = side.uses[side.arrays["faces"]["prototype"]]
    total: Counter[str] = Counter()
    for kind, weight in zip(kind_families(side.sound._core.face_kinds()), weights.tolist(), strict=True):
        total[kind] += weight
    return +total


def counts_of(side: Side) -> dict[str, int]:
    """By what is counted."""
    arrays, uses = side.arrays, side.uses
    shells, faces, edges = arrays["shells"], arrays["faces"], arrays["edges"]
    shell_uses = uses[shells["prototype"]]
    closed = shells["closed"].astype(bool)
    of_solid = shells["solid"] >= 0
    single = (np.diff(shells["faces"], axis=1).ravel() == 1) & ~closed & ~of_solid
    lone = shells["lone"].astype(bool) | single
    solids = np.unique(np.column_stack([shells["prototype"], shells["solid"]])[of_solid], axis=0)
    edge_uses = uses[side.owners("edges")]
    # How often an edge is used by faces, each use of a seam for one.
    degree = np.diff(edges["coedges"], axis=1).ravel()
    real = ~edges["degenerate"].astype(bool)
    return {
        "solids": int(uses[solids[:, 0]].sum()),
        "shells": int(shell_uses[~lone].sum()),
        "closed shells": int(shell_uses[closed].sum()),
        "faces without a shell": int(shell_uses[lone].sum()),
        "faces": int(uses[faces["prototype"]].sum()),
        "triangles": int((uses[faces["prototype"]] * np.diff(faces["triangles"], axis=1).ravel()).sum()),
        "loops": int(uses[faces["prototype"][arrays["loops"]["face"]]].sum()),
        "edges": int(edge_uses[real].sum()),
        "degenerate edges": int(edge_uses[~real].sum()),
        "free edges": int(edge_uses[real & (degree == 1)].sum()),
        "edges of more than two faces": int(edge_uses[real & (degree > 2)].sum()),
        "vertices": int(uses[side.owners("vertices")].sum()),
    }
