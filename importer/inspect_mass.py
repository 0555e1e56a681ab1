"""Volume, area, centroid and inertia of prototypes and of the whole, with the integration's own error."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from OCP.TopoDS import TopoDS_Shape

from .. import _core
from .build_store import build_store
from .extract import build_model
from .inspect_shape import Walk, walk_prototype
from .inspection import Mass
from .report import Report
from .shapes import scene_of_shape

Array = npt.NDArray[np.float64]


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
    face_areas: Array  # nan for faces that cannot be drawn
    inside_out: list[int]  # indices of shells


def measure(store: _core.Store, walks: list[Walk]) -> list[Measured]:
    """Of every prototype, in its own coordinates. store: of the shapes that were walked."""
    found = _core.measure_mass(store)
    values, errors = found["face_integrals"], found["face_integral_errors"]
    shells = store.arrays()["shells"]
    closed = set(shells["faces"][shells["closed"] != 0, 0].tolist())
    return [
        _part(walk, values, errors, origin, closed)
        for walk, origin in zip(walks, found["origins"], strict=True)
    ]


def measure_shape(shape: TopoDS_Shape) -> Mass:
    """Of one shape, where it stands."""
    scene = scene_of_shape(shape)
    model = build_model(scene, Report(), unit="mm", unit_mm=1.0, source={})
    parts = measure(build_store(model), [walk_prototype(scene.parts[0].shape, 0)])
    return whole(parts, model.instance_prototypes.tolist(), model.instance_placements)


def _part(walk: Walk, values: Array, errors: Array, origin: Array, closed: set[int]) -> Measured:
    """values, errors: (n, 11) of all faces, as _core.measure_mass gives them. closed: first faces of shells
    that the store finds closed, of which the walk does not know those made of triangles."""
    numbers = np.array([use.number for use in walk.faces], dtype=np.intp)
    areas = values[numbers, 0]
    body, error = np.zeros(11), 0.0
    inside_out: list[int] = []
    several = {shell.solid for shell in walk.shells if shell.solid >= 0 and _count(walk, shell.solid) > 1}
    for index, shell in enumerate(walk.shells):
        faces = [use.number for use in shell.faces]
        if not (shell.closed or closed.intersection(faces[:1])) or np.isnan(values[faces]).any():
            continue
        integrals, off = values[faces].sum(axis=0), float(errors[faces, 1].sum())
        body, error = body + integrals, error + off
        if integrals[1] < -off and shell.solid not in several:
            inside_out.append(index)
    second = body[[5, 6, 7, 6, 8, 9, 7, 9, 10]].reshape(3, 3)
    moments = Moments(float(body[1]), body[2:5], second, origin)
    mass = replace(
        _mass_of(moments, error),
        area=float(np.nansum(areas)),
        area_error=float(np.nansum(errors[numbers, 0])),
        left_out=tuple(numbers[np.isnan(areas)].tolist()),
    )
    return Measured(mass, moments, areas, inside_out)


def whole(parts: list[Measured], instances: list[int], placements: Array) -> Mass:
    """Of all instances in the world. placements: (n, 12) rows of 3x4 matrices."""
    matrices = placements.reshape(-1, 3, 4)
    middles = [m[:, :3] @ parts[p].moments.origin + m[:, 3] for p, m in zip(instances, matrices, strict=True)]
    total = Moments(0.0, np.zeros(3), np.zeros((3, 3)), np.mean(middles, axis=0))
    area = area_error = volume_error = area_noise = volume_noise = 0.0
    for part, matrix in zip(instances, matrices, strict=True):
        scale = abs(float(np.linalg.det(matrix[:, :3])))
        mass, size = parts[part].mass, scale ** (2.0 / 3.0)
        total = _sum(total, _placed(parts[part].moments, matrix, scale))
        area += size * mass.area
        area_error += size * mass.area_error
        area_noise += size * mass.area_noise
        volume_error += scale * mass.volume_error
        volume_noise += scale * mass.volume_noise
    return replace(
        _mass_of(total, volume_error),
        volume_noise=volume_noise,
        area=area,
        area_error=area_error,
        area_noise=area_noise,
        left_out=tuple(sorted({face for part in instances for face in parts[part].mass.left_out})),
    )


def _count(walk: Walk, solid: int) -> int:
    return sum(shell.solid == solid for shell in walk.shells)


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


def _mass_of(moments: Moments, error: float) -> Mass:
    """error: of the volume; one that may be 0 has no centroid."""
    if abs(moments.mass) <= error:
        return Mass(volume=moments.mass, volume_error=error)
    arm = moments.first / moments.mass
    central = moments.second - moments.mass * np.outer(arm, arm)
    inertia = np.trace(central) * np.eye(3) - central
    return Mass(
        volume=moments.mass,
        volume_error=error,
        centroid=tuple((moments.origin + arm).tolist()),
        inertia=tuple(((inertia + inertia.T) / 2).ravel().tolist()),
    )
