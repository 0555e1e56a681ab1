"""Which placed part of A is which of B, and which face."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .parts import PlacedPart, face_centers, kind_families, placed_parts
from .side import Float64s, Int64s, Side, placed

# Points farther apart than this share of the diagonal are not taken for the same where only the place says
# that they are.
_NEAR = 1e-3
# Pairs whose distances are looked at all at once.
_BLOCK = 1 << 22


@dataclass
class Matching:
    """pairs: placed parts of A and B that are the same; only_a, only_b: those without a partner.

    flat: one of the formats holds no tree, and has the parts of the other one in one: they are not compared.
    """

    a: Side
    b: Side
    pairs: list[tuple[PlacedPart, PlacedPart]]
    only_a: list[PlacedPart]
    only_b: list[PlacedPart]
    flat: bool = False

    @cached_property
    def scale(self) -> float:
        """mm: the larger diagonal."""
        return max(self.a.diagonal, self.b.diagonal)

    @cached_property
    def alike(self) -> list[tuple[str, int, int, Int64s]]:
        """What a part is called, its instances in A and B, and (n, 2) numbers of the same faces."""
        if not self.flat:
            numbers = [(a, b, self._prototypes(a, b)) for a, b in self.pairs]
            return [(a.call(), a.number, b.number, self.faces[key]) for a, b, key in numbers]
        names = [part.call() for part in placed_parts(self.a)]
        places, points = zip(*(_in_world(side) for side in (self.a, self.b)), strict=True)
        near = nearest_pairs(points[0], points[1], _NEAR * self.scale)
        rows = np.column_stack([places[0][near[:, 0]], places[1][near[:, 1]]])
        result = []
        for one, other in np.unique(rows[:, [0, 2]], axis=0).tolist():
            here = (rows[:, 0] == one) & (rows[:, 2] == other)
            result.append((names[one], one, other, rows[here][:, [1, 3]]))
        return result

    def _prototypes(self, a: PlacedPart, b: PlacedPart) -> tuple[int, int]:
        return int(self.a.prototypes[a.number]), int(self.b.prototypes[b.number])

    @cached_property
    def faces(self) -> dict[tuple[int, int], Int64s]:
        """By (prototype of A, prototype of B) of a pair: (n, 2) numbers of faces that are the same."""
        result: dict[tuple[int, int], Int64s] = {}
        centers = face_centers(self.a), face_centers(self.b)
        kinds = [np.array(kind_families(s.sound._core.face_kinds()), dtype=str) for s in (self.a, self.b)]
        for a, b in self.pairs:
            key = self._prototypes(a, b)
            if key in result:
                continue
            # In the world, so that parts with frames of their own compare.
            numbers = [
                np.arange(*s.arrays["prototypes"]["faces"][p])
                for s, p in zip((self.a, self.b), key, strict=True)
            ]
            points = [
                placed(c[n], part.placement) for c, n, part in zip(centers, numbers, (a, b), strict=True)
            ]
            found: list[Int64s] = []
            for kind in np.unique(kinds[0][numbers[0]]):
                which = [np.flatnonzero(k[n] == kind) for k, n in zip(kinds, numbers, strict=True)]
                pairs = nearest_pairs(points[0][which[0]], points[1][which[1]], 0.1 * self.scale)
                found.append(
                    np.column_stack([numbers[0][which[0][pairs[:, 0]]], numbers[1][which[1][pairs[:, 1]]]])
                )
            result[key] = np.concatenate(found) if found else np.empty((0, 2), np.int64)
        return result


def match(a: Side, b: Side) -> Matching:
    """By path and shape, then by path, by name, and at last by shape and place."""
    rest_a, rest_b = placed_parts(a), placed_parts(b)
    if len(rest_a) != len(rest_b) and not (a.holds("tree") and b.holds("tree")):
        return Matching(a, b, [], [], [], flat=True)
    scale = max(a.diagonal, b.diagonal)
    pairs: list[tuple[PlacedPart, PlacedPart]] = []
    stages: list[tuple[Callable[[PlacedPart], Hashable], float]] = [
        (lambda p: (p.path, p.shape.kinds) if p.path else None, np.inf),
        (lambda p: p.path or None, np.inf),
        (lambda p: (p.path[-1], p.shape.kinds) if p.path else None, np.inf),
        (lambda p: (p.shape.name, p.shape.kinds) if p.shape.name else None, _NEAR * scale),
        (lambda p: p.shape.kinds, _NEAR * scale),
        (lambda p: (p.shape.name, p.shape.kinds) if p.shape.name else None, np.inf),
        (lambda p: 0, _NEAR * scale),
        (lambda p: (p.shape.kinds, p.path == ()), np.inf),
    ]
    for key, limit in stages:
        groups = _groups(rest_a, key), _groups(rest_b, key)
        for value, members in groups[0].items():
            others = groups[1].get(value)
            if not others:
                continue
            near = nearest_pairs(_places(members), _places(others), limit)
            pairs += [(members[i], others[j]) for i, j in near.tolist()]
        done = {p.number for p, _ in pairs}, {p.number for _, p in pairs}
        rest_a = [p for p in rest_a if p.number not in done[0]]
        rest_b = [p for p in rest_b if p.number not in done[1]]
    if len(rest_a) == len(rest_b) == 1 and not pairs:  # two files of one part each
        pairs, rest_a, rest_b = [(rest_a[0], rest_b[0])], [], []
    return Matching(a, b, sorted(pairs, key=lambda pair: pair[0].number), rest_a, rest_b)


def _in_world(side: Side) -> tuple[Int64s, Float64s]:
    """(n, 2) instance and face, and (n, 3) middle, of all faces."""
    centers = face_centers(side)
    places, points = [np.empty((0, 2), np.int64)], [np.empty((0, 3))]
    for instance, prototype in enumerate(side.prototypes.tolist()):
        numbers = np.arange(*side.arrays["prototypes"]["faces"][prototype])
        places.append(np.column_stack([np.full(len(numbers), instance), numbers]))
        points.append(placed(centers[numbers], side.placements[instance]))
    return np.concatenate(places), np.concatenate(points)


def _groups(
    parts: Iterable[PlacedPart], key: Callable[[PlacedPart], Hashable]
) -> dict[Hashable, list[PlacedPart]]:
    """Parts of no key (None) are in no group."""
    result: dict[Hashable, list[PlacedPart]] = defaultdict(list)
    for part in parts:
        value = key(part)
        if value is not None:
            result[value].append(part)
    return result


def _places(parts: list[PlacedPart]) -> Float64s:
    """(n, 12): where, and a little of how it is turned, to tell apart what stands at one place."""
    size = max((float(np.ptp(p.shape.vertices, axis=0).max(initial=0.0)) for p in parts), default=0.0)
    return np.array([[*p.center, *(1e-3 * size * p.placement[:, :3]).ravel()] for p in parts])


def nearest_pairs(a: Float64s, b: Float64s, limit: float) -> Int64s:
    """(n, 2) indices of points of a (n, d) and b (m, d), each used once, the nearest first, none farther
    apart than limit."""
    if not len(a) or not len(b):
        return np.empty((0, 2), np.int64)
    first = _equal_pairs(a, b)
    left = [np.setdiff1d(np.arange(len(p)), first[:, k]) for k, p in enumerate((a, b))]
    rest = _greedy_pairs(a[left[0]], b[left[1]], limit)
    return np.concatenate([first, np.column_stack([left[0][rest[:, 0]], left[1][rest[:, 1]]])])


def _equal_pairs(a: Float64s, b: Float64s) -> Int64s:
    """Pairs that agree after rounding: most of what came through a file, without a look at all pairs."""
    step = 1e-7 * max(float(np.abs(a).max()), float(np.abs(b).max()), 1e-300)
    keys = [np.round(p / step).astype(np.int64) for p in (a, b)]
    known: dict[bytes, list[int]] = defaultdict(list)
    for j in range(len(b) - 1, -1, -1):
        known[keys[1][j].tobytes()].append(j)
    pairs = [(i, known[key].pop()) for i, row in enumerate(keys[0]) if known.get(key := row.tobytes())]
    return np.array(pairs, np.int64).reshape(-1, 2)


def _greedy_pairs(a: Float64s, b: Float64s, limit: float) -> Int64s:
    if not len(a) or not len(b):
        return np.empty((0, 2), np.int64)
    if len(a) * len(b) > _BLOCK:  # too many to compare all: in the order of their places
        order = [np.lexsort(p.T[::-1]) for p in (a, b)]
        count = min(len(a), len(b))
        ranked = np.column_stack([order[0][:count], order[1][:count]])
        near = np.linalg.norm(a[order[0][:count]] - b[order[1][:count]], axis=1) <= limit
        return np.asarray(ranked[near], np.int64)
    distances = np.linalg.norm(a[:, None] - b[None], axis=2)
    free: tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]] = np.ones(len(a), bool), np.ones(len(b), bool)
    pairs: list[tuple[int, int]] = []
    for flat in np.argsort(distances, axis=None, kind="stable").tolist():
        i, j = divmod(flat, len(b))
        if free[0][i] and free[1][j]:
            if distances[i, j] > limit:
                break
            free[0][i] = free[1][j] = False
            pairs.append((i, j))
            if len(pairs) == min(len(a), len(b)):
                break
    return np.array(pairs, np.int64).reshape(-1, 2)
