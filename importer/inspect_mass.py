"""Volume, area, centroid and inertia of prototypes and of the whole, with the integration's own error."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS_Shape

from .inspect_shape import Walk, has_surface
from .inspection import Mass

Array = npt.NDArray[np.float64]

# Relative error of each face's integral that is asked for. Gauss-Kronrod integration, OpenCascade's other
# way, takes a thousand times as long on a torus and knows its error no better.
_EPSILON = 1e-10


@dataclass(frozen=True)
class Moments:
    """Integrals over a body: of 1, x and x x^T, the last two about ``origin``."""

    mass: float
    first: Array  # (3,)
    second: Array  # (3, 3)
    origin: Array  # (3,)


@dataclass(frozen=True)
class Measured:
    mass: Mass
    moments: Moments
    face_areas: list[float]
    inside_out: list[int]  # indices of shells


def measure(walk: Walk) -> Measured:
    """Of one prototype, in its own coordinates."""
    low, high = rough_bounds(walk.shape)
    origin = (low + high) / 2
    start = gp_Pnt(*origin)
    areas: list[float] = []
    area_error = 0.0
    weighted = np.zeros(3)
    for use in walk.faces:
        area, error, centre = _area(use.face, start) if has_surface(use.face) else (0.0, 0.0, origin)
        areas.append(area)
        area_error += error
        weighted += area * centre
    total = math.fsum(areas)
    moments = Moments(0.0, np.zeros(3), np.zeros((3, 3)), origin)
    volume_error = 0.0
    inside_out: list[int] = []
    several = {shell.solid for shell in walk.shells if shell.solid >= 0 and _count(walk, shell.solid) > 1}
    for index, shell in enumerate(walk.shells):
        if not shell.closed or not all(has_surface(use.face) for use in shell.faces):
            continue
        properties = GProp_GProps(start)
        error = BRepGProp.VolumeProperties_s(shell.shell, properties, _EPSILON, False, False)
        volume_error += abs(error * properties.Mass())
        moments = _sum(moments, _moments(properties, origin))
        if properties.Mass() < 0.0 and shell.solid not in several:
            inside_out.append(index)
    mass = replace(
        _mass_of(moments),
        volume_error=volume_error,
        area=total,
        area_error=area_error,
        area_centroid=tuple((weighted / total).tolist()) if total > 0.0 else None,
    )
    return Measured(mass, moments, areas, inside_out)


def whole(parts: list[Measured], instances: list[int], placements: Array) -> Mass:
    """Of all instances in the world. placements: (n, 12) rows of 3x4 matrices."""
    matrices = placements.reshape(-1, 3, 4)
    middles = [m[:, :3] @ parts[p].moments.origin + m[:, 3] for p, m in zip(instances, matrices, strict=True)]
    total = Moments(0.0, np.zeros(3), np.zeros((3, 3)), np.mean(middles, axis=0))
    area = area_error = volume_error = area_noise = volume_noise = 0.0
    weighted = np.zeros(3)
    for part, matrix in zip(instances, matrices, strict=True):
        scale = abs(float(np.linalg.det(matrix[:, :3])))
        mass, size = parts[part].mass, scale ** (2.0 / 3.0)
        total = _sum(total, _placed(parts[part].moments, matrix, scale))
        area += size * mass.area
        area_error += size * mass.area_error
        area_noise += size * mass.area_noise
        volume_error += scale * mass.volume_error
        volume_noise += scale * mass.volume_noise
        if mass.area_centroid is not None:
            weighted += size * mass.area * (matrix[:, :3] @ np.array(mass.area_centroid) + matrix[:, 3])
    return replace(
        _mass_of(total),
        volume_error=volume_error,
        volume_noise=volume_noise,
        area=area,
        area_error=area_error,
        area_noise=area_noise,
        area_centroid=tuple((weighted / area).tolist()) if area > 0.0 else None,
    )


def _count(walk: Walk, solid: int) -> int:
    return sum(shell.solid == solid for shell in walk.shells)


def _area(face: TopoDS_Shape, origin: gp_Pnt) -> tuple[float, float, Array]:
    properties = GProp_GProps(origin)
    error = BRepGProp.SurfaceProperties_s(face, properties, _EPSILON, False)
    centre = properties.CentreOfMass()
    return properties.Mass(), abs(error * properties.Mass()), np.array([centre.X(), centre.Y(), centre.Z()])


def _moments(properties: GProp_GProps, origin: Array) -> Moments:
    """From OpenCascade's mass, centre and inertia about the centre."""
    mass = properties.Mass()
    centre = properties.CentreOfMass()
    inertia = properties.MatrixOfInertia()
    about = np.array([[inertia.Value(row, column) for column in (1, 2, 3)] for row in (1, 2, 3)])
    arm = np.array([centre.X(), centre.Y(), centre.Z()]) - origin
    second = np.trace(about) / 2 * np.eye(3) - about
    return Moments(mass, mass * arm, second + mass * np.outer(arm, arm), origin)


def _moved(moments: Moments, origin: Array) -> Moments:
    """The same about another origin."""
    shift = moments.origin - origin
    cross = np.outer(moments.first, shift)
    second = moments.second + cross + cross.T + moments.mass * np.outer(shift, shift)
    return Moments(moments.mass, moments.first + moments.mass * shift, second, origin)


def _sum(a: Moments, b: Moments) -> Moments:
    b = _moved(b, a.origin)
    return Moments(a.mass + b.mass, a.first + b.first, a.second + b.second, a.origin)


def _placed(moments: Moments, matrix: Array, scale: float) -> Moments:
    linear = matrix[:, :3]
    return Moments(
        scale * moments.mass,
        scale * linear @ moments.first,
        scale * linear @ moments.second @ linear.T,
        linear @ moments.origin + matrix[:, 3],
    )


def _mass_of(moments: Moments) -> Mass:
    if moments.mass == 0.0:
        return Mass()
    arm = moments.first / moments.mass
    central = moments.second - moments.mass * np.outer(arm, arm)
    inertia = np.trace(central) * np.eye(3) - central
    return Mass(
        volume=moments.mass,
        centroid=tuple((moments.origin + arm).tolist()),
        inertia=tuple(((inertia + inertia.T) / 2).ravel().tolist()),
    )


def rough_bounds(shape: TopoDS_Shape) -> tuple[Array, Array]:
    """Lower and upper corner of a box that holds the shape; zeros for one without extent or end."""
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid() or box.IsOpen():
        return np.zeros(3), np.zeros(3)
    low, high = box.CornerMin(), box.CornerMax()
    return np.array([low.X(), low.Y(), low.Z()]), np.array([high.X(), high.Y(), high.Z()])
