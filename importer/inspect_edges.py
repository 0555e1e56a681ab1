"""How well edges, p-curves, surfaces and vertices of one prototype fit together.

Every use of an edge is sampled at the same parameters of the edge, and the largest value is then refined
between its neighbours; so a bulge that is narrower than a few samples may be underestimated, never
overestimated.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Shape
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Edge

from .edge_path import EdgePath, coordinates, path_of, vertices_of
from .inspect_shape import CoEdge, Walk, edge_role, has_surface
from .inspection import Fault

Array = npt.NDArray[np.float64]

_SAMPLES = 17
# Values below this are noise of the evaluation, and not refined: mm, radians.
_FINE = 1e-9
_REFINEMENTS = 16
# Tolerances are set by sampling, too: what exceeds one by less than this is none of the file's faults.
_SLACK = 1.1
# Simpson's rule over all samples, of a range of length 1.
_SIMPSON = np.array([1.0, *[4.0, 2.0] * ((_SAMPLES - 3) // 2), 4.0, 1.0]) / (3.0 * (_SAMPLES - 1))
# An angle between normals, beyond which an edge is not meant to be smooth: radians.
_SHARP = 0.1
# Of the largest |S_u x S_v| along an edge: below it, a normal is noise.
_POLE = 1e-6
# A step of the golden section.
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass
class EdgeFacts:
    """As the columns of inspection.Edges."""

    prototype: int
    edge: int
    faces: tuple[int, int]
    uses: int
    length: float
    tolerance: float
    deviation: float
    gap: float
    angle: float
    smooth: bool


@dataclass
class EdgesOfPrototype:
    facts: list[EdgeFacts]
    faults: list[Fault]
    area_noise: float  # mm^2: what trimming at the edges rather than at the p-curves would change
    volume_noise: float  # mm^3: what the strips between the p-curves of an edge would add


def inspect_edges(walk: Walk, prototype: int, origin: Array) -> EdgesOfPrototype:
    """origin: (3,) that the volume's integrals are about."""
    found = EdgesOfPrototype([], [], 0.0, 0.0)
    surfaces: dict[int, BRepAdaptor_Surface] = {}
    for index in range(len(walk.edges)):
        _inspect_edge(walk, prototype, index, surfaces, found, origin)
    return found


def _inspect_edge(
    walk: Walk,
    prototype: int,
    index: int,
    surfaces: dict[int, BRepAdaptor_Surface],
    found: EdgesOfPrototype,
    origin: Array,
) -> None:
    edge, uses = walk.edges[index], walk.coedges[index]
    tolerance = BRep_Tool.Tolerance_s(edge)
    numbers = [coedge.use.number for coedge in uses]
    faces = (numbers[0], numbers[1] if len(numbers) > 1 else -1)
    distinct = tuple(dict.fromkeys(numbers))
    role = edge_role(walk, index)
    facts = EdgeFacts(
        prototype, index, faces, len(uses), 0.0, tolerance, 0.0, math.nan, math.nan, _is_smooth(edge, uses)
    )
    found.facts.append(facts)
    if role == "free":
        found.faults.append(Fault("free edge", "only one face uses it", prototype, distinct, index))
    if role == "non-manifold":
        ways = "" if len(uses) > 2 else " in one direction"
        found.faults.append(
            Fault("non-manifold edge", f"faces use it {len(uses)} times{ways}", prototype, distinct, index)
        )
    images = [image for coedge in uses if (image := _image(coedge, surfaces)) is not None]
    path = path_of(edge, role == "degenerate")
    if path is None:
        if images:
            found.faults.append(
                Fault("not checked", "the edge has no curve in space", prototype, distinct, index)
            )
        return
    if role != "degenerate":
        facts.length = path.length()
        found.faults.extend(_vertices_off(edge, path, prototype, distinct, index))
    samples = np.linspace(path.first, path.last, _SAMPLES)
    on_path, tangents = path.sample(samples)
    on_faces = []
    for image in images:
        points, normals = image.sample(samples)
        on_faces.append((image, points, normals))
        apart = np.linalg.norm(points - on_path, axis=1)
        deviation = skew = _largest(samples, apart, _distance_of(image, path))
        if deviation > _SLACK * tolerance and role != "degenerate":
            fine = _fine_samples(path)
            deviation = min(path.largest_distance(fine, image.sample(fine)[0]), skew)
            if deviation <= _SLACK * tolerance and path.same_parameter:
                what = "a curve on a face runs at other parameters than the edge"
                found.faults.append(
                    Fault("edge out of step", what, prototype, (image.number,), index, skew, tolerance)
                )
        facts.deviation = max(facts.deviation, deviation)
    if facts.deviation > max(_SLACK * tolerance, path.resolution):
        what = "a curve on a face is farther from the edge than its tolerance says"
        found.faults.append(
            Fault("edge off its face", what, prototype, distinct, index, facts.deviation, tolerance)
        )
    if role != "degenerate":
        weights = _SIMPSON * (path.last - path.first)
        _add_noise(found, weights[:, None] * tangents, on_path - origin, on_faces, origin)
        for (a, points_a, normals_a), (b, points_b, normals_b) in itertools.pairwise(on_faces):
            gap = _largest(samples, np.linalg.norm(points_a - points_b, axis=1), _gap_of(a, b))
            facts.gap = float(np.fmax(facts.gap, gap))
            if a.reversed == b.reversed:
                continue  # no neighbours: they face apart, as where two solids share a face
            angles = _angles(normals_a, normals_b)
            # Where faces meet sharply, nobody asks for the last digit.
            sharp = float(np.nanmax(angles, initial=0.0)) > _SHARP
            angle = float(np.nanmax(angles)) if sharp else _largest(samples, angles, _angle_of(a, b))
            facts.angle = float(np.fmax(facts.angle, angle))


def _add_noise(
    found: EdgesOfPrototype,
    steps: Array,
    arms: Array,
    on_faces: list[tuple["_Image", Array, Array]],
    origin: Array,
) -> None:
    """steps: along the edge at each sample, of a quadrature; arms: of its points from the origin.

    The strips between the edge and its images: how much area they have along each face, and how much
    volume the divergence theorem gives them together. Both with their sign along one edge, without it between
    edges."""
    volume = 0.0
    for image, points, normals in on_faces:
        apart = points - (arms + origin)
        strip = np.cross(apart, steps)
        found.area_noise += abs(float(np.nansum(strip * normals)))
        flux = float(np.sum((arms + apart / 2) * strip)) / 3.0
        volume += -flux if image.reversed else flux
    found.volume_noise += abs(volume)


def _fine_samples(path: EdgePath) -> Array:
    """Where a distance from the curve is measured at whatever parameter: it cannot be refined cheaply."""
    return np.linspace(path.first, path.last, 4 * (_SAMPLES - 1) + 1)


class _Image:
    """A use of an edge: its p-curve on the face's surface."""

    def __init__(self, coedge: CoEdge, curve: Any, surface: BRepAdaptor_Surface) -> None:
        self.curve, self.surface, self.number = curve, surface, coedge.use.number
        self.reversed = coedge.reversed
        self.flip = -1.0 if coedge.use.face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
        self._point, self._u, self._v = gp_Pnt(), gp_Vec(), gp_Vec()
        self._largest_cross = 0.0  # |S_u x S_v| at the samples so far

    def point(self, t: float) -> tuple[float, ...]:
        return coordinates(self.surface.Value(*self.curve.Value(t).Coord()))

    def sample(self, at: Array) -> tuple[Array, Array]:
        """Points and unit normals, outwards, (n, 3); a normal is nan where the surface has none, or none but
        rounding: where the edge ends at a pole, it may point either way."""
        points, normals = [], []
        d1, value = self.surface.D1, self.curve.Value
        point, along_u, along_v = self._point, self._u, self._v
        for t in at.tolist():
            d1(*value(t).Coord(), point, along_u, along_v)
            points.append(point.Coord())
            normals.append(along_u.Crossed(along_v).Coord())
        vectors = np.array(normals)
        lengths: Array = np.linalg.norm(vectors, axis=1, keepdims=True)
        self._largest_cross = max(self._largest_cross, float(lengths.max()))
        least = max(1e-12, _POLE * self._largest_cross)
        with np.errstate(invalid="ignore", divide="ignore"):
            units = np.where(lengths > least, vectors / lengths, np.nan)
        oriented: Array = self.flip * units
        return np.array(points), oriented


def _image(coedge: CoEdge, surfaces: dict[int, BRepAdaptor_Surface]) -> _Image | None:
    use = coedge.use
    if not has_surface(use.face):
        return None
    curve = BRep_Tool.CurveOnSurface_s(coedge.oriented, use.face, 0.0, 0.0)
    if curve is None:
        return None
    if use.number not in surfaces:
        surfaces[use.number] = BRepAdaptor_Surface(use.face, False)
    return _Image(coedge, curve, surfaces[use.number])


def _distance_of(image: _Image, path: EdgePath) -> Callable[[float], float]:
    return lambda t: math.dist(image.point(t), path.point(t))


def _gap_of(a: _Image, b: _Image) -> Callable[[float], float]:
    return lambda t: math.dist(a.point(t), b.point(t))


def _angle_of(a: _Image, b: _Image) -> Callable[[float], float]:
    def angle(t: float) -> float:
        at = np.array([t])
        return float(_angles(a.sample(at)[1], b.sample(at)[1])[0])

    return angle


def _angles(a: Array, b: Array) -> Array:
    """Between unit vectors, exact for small angles too; nan stays."""
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1)))


def _largest(samples: Array, values: Array, value: Callable[[float], float]) -> float:
    """The largest value, refined about the largest sample by golden sections; nan where all are."""
    known = np.nan_to_num(values, nan=-1.0)
    best = int(np.argmax(known))
    largest = float(values[best])
    spread = largest - float(known[known >= 0.0].min()) if (known >= 0.0).any() else 0.0
    if math.isnan(largest) or largest < _FINE or spread <= 1e-3 * largest:
        return largest
    low, high = float(samples[max(best - 1, 0)]), float(samples[min(best + 1, len(samples) - 1)])
    a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_a, at_b = value(a), value(b)
    for _ in range(_REFINEMENTS):
        largest = max(largest, at_a, at_b)
        if at_a >= at_b:
            high, b, at_b = b, a, at_a
            a = high - _GOLDEN * (high - low)
            at_a = value(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + _GOLDEN * (high - low)
            at_b = value(b)
    return largest


def _is_smooth(edge: TopoDS_Edge, uses: list[CoEdge]) -> bool:
    """Does the shape claim that the faces meet tangentially?"""
    if len(uses) < 2:
        return False
    a, b = uses[0].use.face, uses[1].use.face
    return bool(
        BRep_Tool.HasContinuity_s(edge, a, b)
        and BRep_Tool.Continuity_s(edge, a, b).value > GeomAbs_Shape.GeomAbs_C0.value
    )


def _vertices_off(
    edge: TopoDS_Edge, path: EdgePath, prototype: int, faces: tuple[int, ...], index: int
) -> list[Fault]:
    faults = []
    for at_end, vertex in vertices_of(edge):
        end = path.point(path.last if at_end else path.first)
        distance = math.dist(end, coordinates(BRep_Tool.Pnt_s(vertex)))
        allowed = BRep_Tool.Tolerance_s(vertex)
        if distance > max(allowed, path.resolution):
            what = (
                f"the vertex at its {'end' if at_end else 'start'} is farther from it than its tolerance says"
            )
            faults.append(Fault("vertex off its edge", what, prototype, faces, index, distance, allowed))
    return faults
