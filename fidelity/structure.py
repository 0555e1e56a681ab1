"""What stands where, and what it is called: unit, instances, names, tree, transforms, layers.

No difference is made of: names that programs make up (part numbers, "SOLID", an OpenCascade release); a level
of the tree without such a name, or with the name of the level below; one more level above all others; the
order of parts; parts stored once or several times; whatever one of the two formats cannot hold.
"""

from __future__ import annotations

import numpy as np

from trimray import Layer

from .findings import count, found, limited, not_held
from .match import Matching
from .parts import PlacedPart
from .record import Finding
from .side import Float64s, Side, placed
from .tolerances import Tolerances


def compare_structure(matching: Matching, tolerances: Tolerances) -> list[Finding]:
    a, b = matching.a, matching.b
    if matching.flat:
        return [_unit(a, b), not_held("structure", "tree", a, b), *_layers(a, b)]
    findings = [
        _unit(a, b),
        count("structure", "instances", (a.prototypes.size, b.prototypes.size)),
        *_lonely(matching),
        *_transforms(matching, tolerances),
    ]
    if a.holds("names") and b.holds("names"):
        findings += _names(matching)
        if a.holds("tree") and b.holds("tree"):
            findings += _levels(matching)
    else:
        findings.append(not_held("structure", "names", a, b))
    return [*findings, *_layers(a, b)]


def _unit(a: Side, b: Side) -> Finding:
    units = a.sound.unit, b.sound.unit
    if a.holds("unit") and b.holds("unit"):
        return found("structure", "unit", units, units[0] == units[1])
    return not_held("structure", "unit", a, b)


def _lonely(matching: Matching) -> list[Finding]:
    """Parts of one model that the other lacks."""
    lost = [
        Finding(
            "structure", "instance", p.call(), None, False, missing=True, where=p.call(), reason="only in A"
        )
        for p in matching.only_a
    ]
    new = [
        Finding(
            "structure", "instance", None, p.call(), False, missing=True, where=p.call(), reason="only in B"
        )
        for p in matching.only_b
    ]
    return limited(lost) + limited(new)


def _transforms(matching: Matching, tolerances: Tolerances) -> list[Finding]:
    """How far any part stands from where it should, and those that are too far."""
    tolerance = tolerances.placement * matching.scale
    worst, wrong = 0.0, []
    for a, b in matching.pairs:
        off = displacement(a, b, matching.scale)
        worst = max(worst, off)
        if off > tolerance:
            values = [np.round(p.placement, 12).tolist() for p in (a, b)]
            wrong.append(
                found(
                    "structure", "transform", values, False, "mm", off, tolerance, where=a.call(),
                    reason="stands elsewhere",
                )
            )  # fmt: skip
    wrong.sort(key=lambda finding: -(finding.difference or 0.0))
    summary = Finding(
        "structure", "transforms", None, None, not wrong, "mm", worst, tolerance,
        reason="largest displacement of a part",
    )  # fmt: skip
    return [summary, *limited(wrong)]


def displacement(a: PlacedPart, b: PlacedPart, scale: float) -> float:
    """mm: how far apart the same points of a part are in the two models.

    Where the parts have the same coordinates, the placements decide. Where they have not, as when a file
    moved a part within its frame, the vertices in the world do, if the placements differ at all.
    """
    corners = _corners(a.shape.vertices)
    moved = placed(corners, a.placement) - placed(corners, b.placement)
    by_frame = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    va, vb = a.shape.vertices, b.shape.vertices
    if by_frame == 0.0 or (va.shape == vb.shape and np.allclose(va, vb, rtol=0.0, atol=1e-9 * scale)):
        return by_frame
    if len(va) == len(vb) and len(va) * len(vb) <= 1 << 22:
        gaps = np.linalg.norm(placed(va, a.placement)[:, None] - placed(vb, b.placement)[None], axis=2)
        return min(by_frame, float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max())))
    return min(by_frame, float(np.linalg.norm(a.center - b.center)))


def _corners(points: Float64s) -> Float64s:
    """(8, 3) of the box of points; of a part without any, of a unit box."""
    box = np.stack([points.min(axis=0), points.max(axis=0)]) if len(points) else np.eye(2, 3)
    if not np.ptp(box):
        box = box + np.array([[-0.5], [0.5]])
    return np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def _names(matching: Matching) -> list[Finding]:
    """Of parts, and of instances that have one of their own. A name may appear where none was."""
    parts, instances = {}, []
    for a, b in matching.pairs:
        if a.shape.name and a.shape.name != b.shape.name:
            parts[a.shape.name, b.shape.name] = a
        elif a.name and a.name != b.name and a.name != a.shape.name:
            instances.append((a.name, b.name, a.call()))
    named = [len({p.shape.name for p in ab if p.shape.name}) for ab in zip(*matching.pairs, strict=True)]
    wrong = [_name("part name", x, y, a.call()) for (x, y), a in parts.items()]
    wrong_instances = [_name("instance name", *entry) for entry in instances]
    summary = found(
        "structure", "part names", named or [0, 0], not wrong, reason="parts with a name of their own"
    )
    return [summary, *limited(wrong), *limited(wrong_instances)]


def _name(what: str, a: str, b: str, where: str) -> Finding:
    return Finding(
        "structure", what, a, b or None, False, missing=not b, where=where,
        reason="renamed" if b else "the name is lost",
    )  # fmt: skip


def _levels(matching: Matching) -> list[Finding]:
    """Whether each part is below the same assemblies."""
    above = [_above(a) for a, _ in matching.pairs], [_above(b) for _, b in matching.pairs]
    for one, other in (above, above[::-1]):  # one more level above all others
        if len({path[:1] for path in one}) == 1 and [path[1:] for path in one] == other:
            return [found("structure", "levels of the tree", [_depth(paths) for paths in above], True)]
    wrong = [
        Finding(
            "structure", "assembly", "/".join(x), "/".join(y), False, where=part.call(),
            reason="below another assembly",
        )
        for (part, _), x, y in zip(matching.pairs, *above, strict=True)
        if x != y
    ]  # fmt: skip
    depths = [_depth(paths) for paths in above]
    return [found("structure", "levels of the tree", depths, not wrong), *limited(wrong)]


def _depth(paths: list[tuple[str, ...]]) -> int:
    return max(map(len, paths), default=0)


def _above(part: PlacedPart) -> tuple[str, ...]:
    """The names above its own."""
    return part.path[:-1] if part.name else part.path


def _layers(a: Side, b: Side) -> list[Finding]:
    """Their names, and how many faces are on them in the world, singly or with their part or instance: one
    format knows layers of the one, another of the other."""
    if not (a.holds("layers") and b.holds("layers")):
        return [not_held("structure", "layers", a, b)]
    sides = [{name: _faces_on(side, layer) for name, layer in side.sound.layers.items()} for side in (a, b)]
    wrong = [
        found(
            "structure",
            "layer",
            [side.get(name) for side in sides],
            False,
            missing=name not in sides[1],
            where=name,
        )
        for name in sorted(sides[0].keys() | sides[1].keys())
        if sides[0].get(name) != sides[1].get(name)
    ]
    return [found("structure", "layers", [len(side) for side in sides], not wrong), *limited(wrong)]


def _faces_on(side: Side, layer: Layer) -> int:
    """Each as often as it is placed."""
    singly = np.bincount(side.arrays["faces"]["prototype"][list(layer.faces)], minlength=len(side.uses))
    every = np.diff(side.arrays["prototypes"]["faces"], axis=1).ravel()
    counts = singly[side.prototypes]
    whole = list(layer.instances)
    counts[whole] = every[side.prototypes[whole]]
    return int(counts.sum())
