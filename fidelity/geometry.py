"""Points of each model held against the other one: distances, and angles between normals.

Every face and edge of every instance has its share of points, so that a small one counts like a large one.
Distances are exact and go both ways: a lost hole is seen from the model that fills it, a lost face from the
one that has it. A face that is turned over has distance 0, and is told by its normals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from trimray.distances import Samples

from .findings import MANY, found, not_comparable
from .match import Matching
from .record import Finding
from .side import Float64s, Int64s, Side
from .tolerances import Tolerances

Bools = npt.NDArray[np.bool_]

# Points of a face or an edge, at least and at most.
_LEAST, _MOST = 6, 4096
# How far off its surface a ray for a normal starts, in tolerances of the distance.
_LIFT = 10.0
# Samples of a face that are compared with those of its partner.
_COMPARED = 256


@dataclass(frozen=True)
class Deviation:
    """Of points of one model from the other.

    distance: (n,) mm. angle: (n,) radians, nan where there is no normal to compare. item: (n,) number of the
    face or edge. point: (n, 3). other: (n,) the nearest face of the other model, -1 for none.
    """

    point: Float64s
    item: Int64s
    distance: Float64s
    angle: Float64s
    other: Int64s

    def largest(self) -> float:
        return float(self.distance.max(initial=0.0))

    def quantile(self, share: float) -> float:
        return float(np.quantile(self.distance, share)) if len(self.distance) else 0.0

    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.distance**2))) if len(self.distance) else 0.0

    def turned(self) -> float:
        """The largest angle."""
        return float(np.nanmax(self.angle)) if np.isfinite(self.angle).any() else 0.0


def compare_geometry(
    matching: Matching, tolerances: Tolerances, *, points: int, seed: int, threads: int = 0
) -> list[Finding]:
    """points: on the faces of each, and half as many on the edges, or more, if there are many."""
    a, b = matching.a, matching.b
    drawable = [side.diagonal > 0.0 for side in (a, b)]
    if not all(drawable):
        return [not_comparable("geometry", "distances", drawable, "no face can be drawn")]
    scale = max(a.diagonal, b.diagonal)
    tolerance = tolerances.distance * scale
    both = (a, b), (b, a)
    samples = [side.sound.sample(_share(points, _faces(side)), seed=seed, threads=threads) for side in (a, b)]
    faces = []
    for k, (side, other) in enumerate(both):
        near = _Nearness(side, other, tolerance, tolerances.normal, threads)
        faces.append(near.deviation(samples[k], samples[1 - k], partners(matching, turned=k == 1)))
    edges = [edge_deviation(x, y, points // 2, seed, threads) for x, y in both]
    findings = []
    for what, pair in (("faces", faces), ("edges", edges)):
        for name, values in (
            ("largest distance", [d.largest() for d in pair]),
            ("95 % of distances", [d.quantile(0.95) for d in pair]),
            ("RMS distance", [d.rms() for d in pair]),
        ):
            findings.append(
                found(
                    "geometry", f"{name} of {what}", values, max(values) <= tolerance, "mm", max(values),
                    tolerance, reason="of A from B, and of B from A",
                )
            )  # fmt: skip
    angles = [d.turned() for d in faces]
    findings.append(
        found(
            "geometry", "largest angle of normals", angles, max(angles) <= tolerances.normal, "rad",
            max(angles), tolerances.normal, reason="of A from B, and of B from A",
        )
    )  # fmt: skip
    for (side, other), deviation, called in zip(both, faces, "AB", strict=True):
        findings += worst_faces(side, other, deviation, tolerance, tolerances.normal, called)
    for (side, _), deviation, called in zip(both, edges, "AB", strict=True):
        findings += worst_edges(side, deviation, tolerance, called)
    return findings


def _faces(side: Side) -> int:
    """In the world."""
    return int(side.uses[side.arrays["faces"]["prototype"]].sum())


Place = tuple[int, int]  # instance and face


def partners(matching: Matching, *, turned: bool = False) -> dict[Place, Place]:
    """By face at a place of A: that of B. turned: the other way round."""
    result: dict[Place, Place] = {}
    for _, number_a, number_b, faces in matching.alike:
        for face_a, face_b in faces.tolist():
            one, other = (number_a, face_a), (number_b, face_b)
            result[other if turned else one] = one if turned else other
    return result


@dataclass(frozen=True)
class _Nearness:
    """Of points on the faces of one model from the other. tolerance: mm; angle: radians."""

    side: Side
    other: Side
    tolerance: float
    angle: float
    threads: int

    def deviation(self, samples: Samples, others: Samples, partner: dict[Place, Place]) -> Deviation:
        """others: of the other model."""
        near = self.other.sound.distance(samples.point, threads=self.threads)
        angle = self._angles(self.other, samples.point, samples.normal, near.distance)
        _excuse_contacts(angle, samples, others, partner)
        distance = near.distance.copy()
        self._excuse_ends(samples, distance, angle)
        self._excuse_noise(samples, angle)
        numbers = samples.face.astype(np.int64), near.face.astype(np.int64)
        return Deviation(samples.point, numbers[0], distance, angle, numbers[1])

    def _excuse_ends(self, samples: Samples, distance: Float64s, angle: Float64s) -> None:
        """Near an edge, p-curves may put the end of a face beyond the edge. How far is up to the file, and no
        difference between models."""
        rows = np.flatnonzero((distance > self.tolerance) | (np.nan_to_num(angle) > self.angle))
        if not len(rows):
            return
        edges = self.side.sound.distance(samples.point[rows], edges=True, threads=self.threads)
        at_end = edges.distance <= edges.band + self.tolerance
        angle[rows[at_end]] = np.nan
        allowed = np.where(at_end, edges.band, 0.0)
        distance[rows] = np.where(distance[rows] <= allowed + self.tolerance, 0.0, distance[rows])

    def _excuse_noise(self, samples: Samples, angle: Float64s) -> None:
        """Where the surface bends within the tolerance, as at a pole, so may its normal."""
        rows = np.flatnonzero((np.nan_to_num(angle) > self.angle) & (np.nan_to_num(angle) < 0.5 * np.pi))
        if not len(rows):
            return
        normals = samples.normal[rows]
        across = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        bend = np.zeros(len(rows))
        for direction in (across, -across, np.cross(normals, across), -np.cross(normals, across)):
            moved = samples.point[rows] + self.tolerance * direction
            here = self._angles(self.side, moved, normals, np.zeros(len(rows)))
            bend = np.fmax(bend, here)
        angle[rows[angle[rows] <= self.angle + 2.0 * bend]] = np.nan

    def _angles(self, model: Side, points: Float64s, normals: Float64s, distance: Float64s) -> Float64s:
        """(n,): between the normals and the outward normals of a model below the points, at these distances
        from it; nan where it is too far."""
        lift = max(_LIFT * self.tolerance, 1e-7 * model.diagonal)
        result = np.full(len(points), np.nan)
        rows = np.flatnonzero(distance <= 0.5 * lift)
        if not len(rows):
            return result
        hits = model.sound.cast(
            points[rows] + lift * normals[rows], -normals[rows], tmax=2.0 * lift, threads=self.threads
        )
        hit = np.isfinite(hits.t)
        normal, rows = hits.normal[hit], rows[hit]
        cross = np.linalg.norm(np.cross(normals[rows], normal), axis=1)
        result[rows] = np.arctan2(cross, np.einsum("ij,ij->i", normals[rows], normal))
        return result


def _excuse_contacts(angle: Float64s, samples: Samples, others: Samples, partner: dict[Place, Place]) -> None:
    """Where two parts touch, a ray meets their faces at once, and may tell of the wrong one. There the
    normals of the partner's own samples say whether it is turned over, all of it as it must be."""
    turned = np.nan_to_num(angle) > 0.5 * np.pi
    if not turned.any():
        return
    places = np.column_stack([samples.instance, samples.face])
    of_others = np.column_stack([others.instance, others.face])
    for place in np.unique(places[turned], axis=0):
        found = partner.get((int(place[0]), int(place[1])))
        if found is None:
            continue
        here = np.flatnonzero((places == place).all(axis=1))
        there = np.flatnonzero((of_others == found).all(axis=1))
        if len(there) and _upright(samples, _some(here), others, _some(there)):
            angle[here[turned[here]]] = np.nan


def _some(rows: Int64s) -> Int64s:
    return rows[:: -(-len(rows) // _COMPARED)]


def _upright(samples: Samples, here: Int64s, others: Samples, there: Int64s) -> bool:
    """Whether the samples of two faces that are the same face the same way. Where they are few, the nearest
    one may be across a cylinder, so that all together have to say."""
    gaps = np.linalg.norm(samples.point[here][:, None] - others.point[there][None], axis=2)
    nearest = there[gaps.argmin(axis=1)]
    return float(np.einsum("ij,ij->", samples.normal[here], others.normal[nearest])) > 0.0


def edge_deviation(a: Side, b: Side, points: int, seed: int, threads: int) -> Deviation:
    """Of points on the edges of a from the edges of b. Seams are left out: where a closed surface begins is
    no matter of its shape."""
    edges = int(a.uses[a.owners("edges")].sum())
    samples = a.sound.sample_edges(_share(points, edges), seed=seed, threads=threads)
    seams = np.unique(a.arrays["coedges"]["edge"][a.arrays["coedges"]["seam"].astype(bool)])
    keep = ~np.isin(samples.edge, seams)
    where, numbers = samples.point[keep], samples.edge[keep].astype(np.int64)
    near = b.sound.distance(where, edges=True, threads=threads)
    # A model without edges, such as a mesh, has none to compare.
    distance = np.where(np.isfinite(near.distance), near.distance, 0.0)
    return Deviation(where, numbers, distance, np.full(len(where), np.nan), near.face.astype(np.int64))


def _share(points: int, items: int) -> int:
    """Points for each of the items."""
    return int(np.clip(-(-points // max(items, 1)), _LEAST, _MOST))


def worst_faces(
    side: Side, other: Side, deviation: Deviation, tolerance: float, angle: float, called: str
) -> list[Finding]:
    """Of every face that is off: its worst point. called: "A" or "B", which side is."""
    far = deviation.distance > tolerance
    turned = np.nan_to_num(deviation.angle) > angle
    groups = _worst(deviation.item, far, deviation.distance)
    known = {int(deviation.item[rows[0]]) for rows in groups}
    alike = [
        rows
        for rows in _worst(deviation.item, turned, np.nan_to_num(deviation.angle))
        if int(deviation.item[rows[0]]) not in known
    ]
    wrong = limited_groups(
        groups, lambda rows: _face_off(side, other, deviation, rows, far, tolerance, called)
    )
    return wrong + limited_groups(
        alike, lambda rows: _face_turned(side, other, deviation, rows, turned, angle, called)
    )


def _worst(items: Int64s, wrong: Bools, values: Float64s) -> list[Int64s]:
    """Rows of each item of which anything is wrong, by its largest value; the row with that value first."""
    bad = np.unique(items[wrong])
    rows = np.flatnonzero(np.isin(items, bad))
    rows = rows[np.lexsort((-values[rows], items[rows]))]
    groups = np.split(rows, np.flatnonzero(np.diff(items[rows])) + 1) if len(rows) else []
    return sorted(groups, key=lambda group: -float(values[group[0]]))


def limited_groups(groups: list[Int64s], finding_of: Callable[[Int64s], Finding]) -> list[Finding]:
    """One finding for each of the first groups, and one for all the others."""
    made = [finding_of(rows) for rows in groups[: MANY + 1]]
    if len(groups) <= MANY:
        return made
    more = replace(
        made[-1], a=None, b=None, difference=None, where="", reason=f"and {len(groups) - MANY} more"
    )
    return [*made[:MANY], more]


def _face_off(
    side: Side, other: Side, deviation: Deviation, rows: Int64s, far: Bools, tolerance: float, called: str
) -> Finding:
    where, numbers, reason = _named(side, other, deviation, rows, far, called)
    return found(
        "geometry", "face off", numbers, False, "mm", float(deviation.distance[rows[0]]), tolerance,
        where=where, reason=reason,
    )  # fmt: skip


def _face_turned(
    side: Side, other: Side, deviation: Deviation, rows: Int64s, turned: Bools, angle: float, called: str
) -> Finding:
    where, numbers, reason = _named(side, other, deviation, rows, turned, called)
    return found(
        "geometry", "face turned", numbers, False, "rad", float(deviation.angle[rows[0]]), angle,
        where=where, reason=reason,
    )  # fmt: skip


def _named(
    side: Side, other: Side, deviation: Deviation, rows: Int64s, wrong: Bools, called: str
) -> tuple[str, tuple[int | None, int | None], str]:
    """Place, numbers of A's and B's face, and how much of it is wrong."""
    face, partner = int(deviation.item[rows[0]]), partner_of(deviation, rows)
    of = f", nearest is {other.where(partner)} of {'B' if called == 'A' else 'A'}" if partner >= 0 else ""
    where = f"{side.where(face)} of {called} at {_at(deviation.point[rows[0]])}"
    return where, _sided(called, face, partner), f"{int(wrong[rows].sum())} of {len(rows)} points{of}"


def worst_edges(side: Side, deviation: Deviation, tolerance: float, called: str) -> list[Finding]:
    """Of every edge that is off: its worst point."""
    coedges = side.arrays["coedges"]

    def edge_off(rows: Int64s) -> Finding:
        edge = int(deviation.item[rows[0]])
        owner = side.where(int(coedges["face"][coedges["edge"] == edge][0]))
        return found(
            "geometry", "edge off", _sided(called, edge, -1), False, "mm", float(deviation.distance[rows[0]]),
            tolerance, where=f"edge {edge} of {owner} of {called} at {_at(deviation.point[rows[0]])}",
        )  # fmt: skip

    far = deviation.distance > tolerance
    return limited_groups(_worst(deviation.item, far, deviation.distance), edge_off)


def partner_of(deviation: Deviation, rows: Int64s) -> int:
    """The face of the other model that is nearest to most of these points; -1 for none."""
    faces = deviation.other[rows]
    faces = faces[faces >= 0]
    return int(np.bincount(faces).argmax()) if len(faces) else -1


def _sided(called: str, own: int, partner: int) -> tuple[int | None, int | None]:
    """Numbers of A's and of B's face or edge."""
    other = partner if partner >= 0 else None
    return (own, other) if called == "A" else (other, own)


def _at(point: Float64s) -> str:
    return f"({', '.join(f'{x:.6g}' for x in point.tolist())})"
