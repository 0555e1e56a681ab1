"""check: a file against itself: what it declares (A) against what arrived (B), and what is wrong with it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

import trimray
from trimray.views import choose

from .record import Comparison, Finding, Section, verdict_of
from .tolerances import PROFILES, Tolerances

if TYPE_CHECKING:
    from trimray.importer.inspection import Count, Fault, Inspection, Lost, ValidationProperty

# Of one kind of fault so many are listed, and the others counted.
_MOST = 200
# Radians: OpenCascade's readers call two faces smooth where their normals differ by no more than half of it.
SMOOTH = 0.02

# Healing splits and merges these, and files hold some that no face uses: their numbers prove nothing.
_LOOSE = ("edges", "vertices", "loops")
_SECTIONS: dict[str, Section] = {
    "invalid": "topology",
    "not checked": "topology",
    "free edge": "topology",
    "non-manifold edge": "topology",
    "inside out": "topology",
    "edge off its face": "geometry",
    "edge out of step": "geometry",
    "vertex off its edge": "geometry",
}


def check(source: Any, *, profile: str = "default", name: str | None = None, **options: Any) -> Comparison:
    """A file against itself: counts, validation properties, lost entities, faults of shapes and edges, faces
    that cannot be drawn.

    source: as of ``trimray.inspect``; options: as of ``trimray.load`` and ``trimray.inspect``. profile: of
    tolerances.
    Raises InputError, LimitError, UsageError.
    """
    tolerances = PROFILES[choose("profile", profile, PROFILES)]
    model = trimray.load(source, name=name, **options)
    options.pop("cache", None)
    inspection = trimray.inspect(source, name=name, **options)
    findings = findings_of(inspection, tolerances, model)
    return Comparison(
        f"{inspection.name} as declared",
        inspection.name,
        profile,
        findings,
        seconds=dict(inspection.seconds),
        verdict=verdict_of(findings),
    )


def findings_of(inspection: Inspection, tolerances: Tolerances, model: trimray.Model) -> tuple[Finding, ...]:
    """a is what should be, b what is."""
    return (
        Finding("file", "format", None, inspection.format, True),
        Finding("structure", "unit", None, inspection.unit, True),
        *(_count(count) for count in inspection.counts),
        *_lost(inspection.lost, tolerances),
        *_undrawn(model),
        *(_property(one, inspection, tolerances) for one in inspection.properties),
        *_faults(inspection),
        *_edges(inspection),
    )


def _count(count: Count) -> Finding:
    """Fewer than declared is a loss; more is what healing makes by splitting."""
    declared, arrived = count.declared, count.arrived
    reason, same = "", True
    if declared is None or arrived is None:
        reason = "not compared: " + ("the file does not say" if declared is None else "the model keeps none")
    elif count.name in _LOOSE:
        reason = "" if arrived == declared else "not judged: readers split and merge these"
    else:
        same = arrived >= declared
        reason = "more than declared: the reader splits and sews" if arrived > declared else ""
    difference = None if declared is None or arrived is None else float(arrived - declared)
    section: Section = "structure" if count.name in ("products", "instances") else "topology"
    return Finding(
        section,
        f"{count.name} in the file",
        declared,
        arrived,
        same,
        "",
        difference,
        None,
        not same,
        "",
        reason,
    )


def _lost(lost: Iterable[Lost], tolerances: Tolerances) -> Iterator[Finding]:
    """Warnings are of repairs: only the strict profile counts them."""
    strict = tolerances == PROFILES["strict"]
    known = list(lost)
    if not known:
        yield Finding("file", "entities that did not arrive", 0, 0, True)
    for one in known:
        error = one.severity == "error"
        arrived = None if error else "repaired"
        bad = error or (strict and one.severity == "warning")
        yield Finding(
            "file", one.kind, one.entity or "whole", arrived, not bad, missing=error, where=one.entity,
            reason=one.reason,
        )  # fmt: skip


def _undrawn(model: trimray.Model) -> Iterator[Finding]:
    faces = model.report.not_drawn
    if not faces:
        yield Finding("file", "faces that cannot be drawn", 0, 0, True)
    for face in faces:
        yield Finding(
            "file", "drawable", True, False, False, missing=True, where=face.call(),
            reason=str(face.status),
        )  # fmt: skip


def _property(one: ValidationProperty, inspection: Inspection, tolerances: Tolerances) -> Finding:
    """Of volume and area the difference is relative; of a centroid, a part of the diagonal."""
    allowed = float(getattr(tolerances, one.quantity))
    if 0 <= one.prototype < len(inspection.prototypes):
        allowed += _noise(one.quantity, inspection.prototypes[one.prototype].mass)
    judged = one.relative is not None and not one.reason
    same = not judged or bool(one.relative is not None and one.relative <= allowed)
    return Finding(
        "mass", f"declared {one.quantity}", _plain(one.value), _plain(one.measured), same, "",
        one.relative, allowed if judged else None, where=" ".join(x for x in (one.of, one.entity) if x),
        reason=one.reason,
    )  # fmt: skip


def _noise(quantity: str, mass: Any) -> float:
    """Relative: what is not known any better of the measured value."""
    if quantity == "area":
        return float((mass.area_error + mass.area_noise) / mass.area) if mass.area else 0.0
    return float((mass.volume_error + mass.volume_noise) / abs(mass.volume)) if mass.volume else 0.0


def _faults(inspection: Inspection) -> Iterator[Finding]:
    kinds = {kind: list(group) for kind, group in groupby(sorted(inspection.faults, key=_kind), key=_kind)}
    for kind, section in _SECTIONS.items():
        faults = kinds.pop(kind, [])
        if not faults:
            if kind != "not checked":
                yield Finding(section, kind, 0, 0, True)
            continue
        yield from _some(section, kind, [_fault(section, fault, inspection) for fault in faults])
    for kind, faults in kinds.items():
        yield from _some("topology", kind, [_fault("topology", fault, inspection) for fault in faults])


def _kind(fault: Fault) -> str:
    return fault.kind


def _some(section: Section, kind: str, findings: list[Finding]) -> Iterator[Finding]:
    """The first ones of those that differ, and the number of the others; the number of those that may be."""
    wrong = [finding for finding in findings if not finding.same]
    allowed = [finding for finding in findings if finding.same]
    yield from wrong[:_MOST]
    if len(wrong) > _MOST:
        yield Finding(section, f"{kind}: more of them", 0, len(wrong) - _MOST, False)
    if allowed:
        yield Finding(
            section, f"{kind}, allowed", None, len(allowed), True, reason=f"not judged: {allowed[0].reason}"
        )


def _fault(section: Section, fault: Fault, inspection: Inspection) -> Finding:
    same, reason = False, fault.what
    if fault.kind == "free edge" and inspection.prototypes[fault.prototype].topology.solids == 0:
        if any(count.name == "closed shells" and count.missing for count in inspection.counts):
            reason += ", and a shell that the file declares closed arrived open"
        else:
            same, reason = True, "the border of an open surface"
    if fault.kind == "not checked":
        same = True
    distance = fault.value is not None
    return Finding(
        section, fault.kind, fault.allowed if distance else 0, fault.value if distance else 1, same,
        "mm" if distance else "", fault.value, fault.allowed, where=_place(fault, inspection), reason=reason,
    )  # fmt: skip


def _place(fault: Fault, inspection: Inspection) -> str:
    words = []
    if fault.edge >= 0:
        words.append(f"edge {fault.edge}")
    if fault.faces:
        shown = ", ".join(str(face) for face in fault.faces[:4])
        more = f" and {len(fault.faces) - 4} more" if len(fault.faces) > 4 else ""
        words.append(f"face{'s' if len(fault.faces) > 1 else ''} {shown}{more}")
    if 0 <= fault.prototype < len(inspection.prototypes) and inspection.prototypes[fault.prototype].name:
        words.append(f"of {inspection.prototypes[fault.prototype].name}")
    return " ".join(words)


def _edges(inspection: Inspection) -> Iterator[Finding]:
    """The worst ones. How far p-curves may be from their edges, each edge says itself: see the faults."""
    edges = inspection.edges
    for column, name in (
        ("deviation", "largest distance of an edge from its curves on the faces"),
        ("gap", "largest gap between two faces along their edge (G0)"),
    ):
        worst = edges.worst(column, 1)
        if worst:
            value = float(worst[0][column])
            yield Finding(
                "geometry", name, worst[0]["tolerance"], value, True, "mm", value, where=_edge(worst[0]),
                reason="not judged: the edge's own tolerance says what may be",
            )  # fmt: skip
    claimed = np.where(edges.smooth, np.nan_to_num(edges.angle, nan=0.0), 0.0)
    if len(claimed) and bool(edges.smooth.any()):
        angle = float(claimed.max())
        place = f"edge {int(edges.edge[int(claimed.argmax())])}"
        yield Finding(
            "geometry", "largest angle where faces are said to be smooth (G1)", 0.0, angle, angle <= SMOOTH,
            "rad", angle, SMOOTH, where=place,
        )  # fmt: skip


def _edge(row: dict[str, Any]) -> str:
    faces = [str(face) for face in row["faces"] if face >= 0]
    return f"edge {row['edge']} between faces {' and '.join(faces)}"


def _plain(value: float | tuple[float, ...] | None) -> Any:
    if isinstance(value, tuple):
        return [float(x) for x in value]
    return value if value is None or math.isfinite(value) else str(value)
