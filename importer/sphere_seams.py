"""Spheres of a STEP file whose seam runs along the edge of a face that reaches both poles.

Such a face is the part of the sphere on one side of its loop, or on the other: only the loop's direction
tells. A file gives its edges in space, OpenCascade puts them on the sphere, and an edge on the seam may come
to lie a whole turn away from where the others are. It then reads the loop as running the other way round,
turns it, and takes the rest of the sphere. Nothing is ambiguous once the seam lies clear of the loop. A
sphere has no preferred axes, so the seam is moved before OpenCascade looks at it: no point changes.
"""

import contextlib
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.Precision import Precision
from OCP.StepGeom import (
    StepGeom_Axis2Placement3d,
    StepGeom_Direction,
    StepGeom_SphericalSurface,
    StepGeom_SurfaceCurve,
)
from OCP.StepShape import (
    StepShape_EdgeCurve,
    StepShape_EdgeLoop,
    StepShape_FaceSurface,
    StepShape_VertexPoint,
)
from OCP.StepToGeom import StepToGeom
from OCP.TCollection import TCollection_HAsciiString
from OCP.TColStd import TColStd_HArray1OfReal

from .step_text import StepText

Points = NDArray[np.float64]

# Points taken of a whole curve: of a circle, one every 0.05 rad.
_SAMPLES = 129
# Longitudes, rad, that must be free on both sides of a seam.
_CLEAR = 0.05
# Of the radius: nearer to a pole there is no longitude.
_POLE = 1e-4


def clear_seams(model: Any, text: StepText) -> list[str]:
    """Moves the seams of spheres away from the edges of faces that reach both poles; which faces, as "#12".

    model: the Interface_InterfaceModel of a parsed STEP file, before its transfer. text: of that file.
    """
    cleared: list[str] = []
    if b"SPHERICAL_SURFACE" not in text.data:
        return cleared
    ids, faces = text.record_ids, {face.id for face in text.faces}
    known = len(ids) == model.NbEntities()
    for number in range(1, model.NbEntities() + 1):
        if known and int(ids[number - 1]) not in faces:
            continue
        face = model.Value(number)
        if isinstance(face, StepShape_FaceSurface):
            sphere = face.FaceGeometry()
            if isinstance(sphere, StepGeom_SphericalSurface) and face.NbBounds() == 1:
                with contextlib.suppress(Exception), np.errstate(all="ignore"):  # broken: left as it is
                    if _clear_seam(face, sphere):
                        cleared.append(f"#{int(ids[number - 1])}" if known else f"entity {number}")
    return cleared


def _clear_seam(face: Any, sphere: Any) -> bool:
    loop = face.BoundsValue(1).Bound()
    geometry = StepToGeom.MakeSphericalSurface_s(sphere)
    if geometry is None or not isinstance(loop, StepShape_EdgeLoop):
        return False
    frame = geometry.Position()
    axes = np.array(
        [(d.X(), d.Y(), d.Z()) for d in (frame.XDirection(), frame.YDirection(), frame.Direction())]
    )
    centre = frame.Location()
    points = _loop(loop, np.array([centre.X(), centre.Y(), centre.Z()]), axes / sphere.Radius())
    if points is None:
        return False
    if bool(face.BoundsValue(1).Orientation()) != bool(face.SameSense()):
        points = points[::-1]
    angle = _free_longitude(points)
    if angle is None:
        return False
    x = math.cos(angle) * axes[0] + math.sin(angle) * axes[1]
    face.SetFaceGeometry(_turned(sphere, x, axes[2]))
    return True


def _free_longitude(points: Points) -> float | None:
    """Where the seam of a unit sphere can go, in rad; None where it may stay or where nothing is free.

    points: of a closed loop through both poles, with the face on its left.
    """
    away = np.hypot(points[:, 0], points[:, 1]) > _POLE
    longitude = np.arctan2(points[away, 1], points[away, 0])
    latitude = np.arcsin(np.clip(points[away, 2], -1.0, 1.0))
    taken = np.sort(longitude)
    gaps = np.diff(taken, append=taken[0] + math.tau)
    index = np.flatnonzero(away)
    joined = np.diff(index, append=index[0] + len(points)) == 1  # with the next, not across a pole
    found = None
    for i in np.argsort(-gaps):
        start, gap = float(taken[i]), float(gaps[i])
        if gap <= 2.0 * _CLEAR:
            break
        turned = (longitude - start - 1e-9) % math.tau
        if np.any(np.abs(np.roll(turned, -1) - turned)[joined] > math.pi):
            continue  # here the loop goes through, between two points
        if _area(turned, latitude) <= 0.0:
            continue  # here lies the face itself
        if _CLEAR < -start % math.tau < gap - _CLEAR:
            return None
        if found is None:
            found = start + 0.5 * gap
    return found


def _area(u: Points, v: Points) -> float:
    """Twice that of a polygon, negative where it runs clockwise."""
    return float(np.sum(u * np.roll(v, -1) - np.roll(u, -1) * v))


def _loop(loop: Any, centre: Points, axes: Points) -> Points | None:
    """Points of a loop in a unit sphere's own axes; None unless it has vertices at both poles and its edges
    are given in space alone.

    axes: three rows, over the radius.
    """
    uses = [loop.EdgeListValue(index) for index in range(1, loop.NbEdgeList() + 1)]
    edges = [use.EdgeElement() for use in uses]
    if not edges or not all(isinstance(edge, StepShape_EdgeCurve) for edge in edges):
        return None
    vertices = [(_vertex(edge.EdgeStart()), _vertex(edge.EdgeEnd())) for edge in edges]
    ends = np.array(vertices, dtype=np.float64)  # edge, start or end, coordinate
    corners = (ends.reshape(-1, 3) - centre) @ axes.T
    height = corners[np.hypot(corners[:, 0], corners[:, 1]) <= _POLE, 2]
    if not (np.any(height > 0.0) and np.any(height < 0.0)):
        return None
    parts = []
    for use, edge, pair in zip(uses, edges, ends, strict=True):
        part = _edge(edge, pair)
        if part is None:
            return None
        parts.append(part if use.Orientation() else part[::-1])
    return (np.concatenate(parts) - centre) @ axes.T


def _vertex(vertex: Any) -> list[float]:
    if not isinstance(vertex, StepShape_VertexPoint):
        raise TypeError("a vertex without a point")
    point = vertex.VertexGeometry()
    return [point.CoordinatesValue(i) for i in (1, 2, 3)]


def _edge(edge: Any, ends: Points) -> Points | None:
    """Points of an edge from its start to its end. ends: those two."""
    curve = edge.EdgeGeometry()
    if isinstance(curve, StepGeom_SurfaceCurve):
        geometry = (curve.AssociatedGeometryValue(i) for i in range(1, curve.NbAssociatedGeometry() + 1))
        if any(g.Pcurve() is not None for g in geometry):
            return None
        curve = curve.Curve3d()
    shape = StepToGeom.MakeCurve_s(curve) if curve is not None else None
    if shape is None:
        return None
    first, last = shape.FirstParameter(), shape.LastParameter()
    if Precision.IsInfinite_s(first) or Precision.IsInfinite_s(last):
        return None
    values = [shape.Value(float(t)) for t in np.linspace(first, last, _SAMPLES)]
    points = np.array([(p.X(), p.Y(), p.Z()) for p in values])
    if not edge.SameSense():
        points = points[::-1]
    start, end = (int(np.argmin(np.linalg.norm(points - end, axis=1))) for end in ends)
    if shape.IsClosed():  # its last point is its first
        end = (end - start - 1) % (_SAMPLES - 1) + 1
        points, start = np.roll(points[:-1], -start, axis=0), 0
    return np.concatenate([ends[:1], points[start + 1 : end], ends[1:]])


def _turned(sphere: Any, x: Points, z: Points) -> StepGeom_SphericalSurface:
    """The same sphere about the same axis, with its seam in the direction x."""
    name = TCollection_HAsciiString("")
    placement, turned = StepGeom_Axis2Placement3d(), StepGeom_SphericalSurface()
    placement.Init(name, sphere.Position().Location(), True, _direction(z), True, _direction(x))
    turned.Init(sphere.Name() or name, placement, sphere.Radius())
    return turned


def _direction(values: Points) -> StepGeom_Direction:
    ratios = TColStd_HArray1OfReal(1, 3)
    for i, value in enumerate(values, start=1):
        ratios.SetValue(i, float(value))
    direction = StepGeom_Direction()
    direction.Init(TCollection_HAsciiString(""), ratios)
    return direction
