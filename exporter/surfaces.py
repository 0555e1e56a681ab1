"""From the store's surfaces to OpenCascade's, each in its own kind and over the same (u, v)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_BezierSurface,
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_ConicalSurface,
    Geom_Curve,
    Geom_CylindricalSurface,
    Geom_OffsetSurface,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_Surface,
    Geom_SurfaceOfLinearExtrusion,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
)
from OCP.gp import gp_Ax1, gp_Ax3, gp_Pnt
from OCP.TColgp import TColgp_Array2OfPnt
from OCP.TColStd import TColStd_Array2OfReal

from .curves import direction, integers, point, reals, space_curve
from .splines import Floats, Spline, distinct, over_unit

# store.h, SurfaceKind
PLANE, CYLINDER, CONE, SPHERE, TORUS = range(5)
EXTRUSION, REVOLUTION, BEZIER, BSPLINE, OFFSET, MESH, NO_SURFACE = range(5, 12)
_FULL = 1e-9  # of a period


class SurfaceError(ValueError):
    """A surface that has no like in OpenCascade."""


def surface_of(arrays: dict[str, Any], index: int, within: Floats | None = None) -> Geom_Surface:
    """The surface of a face, in the coordinates of its prototype. Raises SurfaceError.

    within: the box (2, 2) in (u, v) to which a spline is cut. The store continues splines a little beyond
    their ends; one that closes up at a seam does so at these ends alone.
    """
    f = arrays["surfaces"][index]
    basis = _basis(arrays, f, within)
    if int(f["kind"]) != OFFSET:
        return basis
    return Geom_OffsetSurface(basis, float(f["offset"]), True)


def _basis(arrays: dict[str, Any], f: Any, within: Floats | None) -> Geom_Surface:
    kind = int(f["basis"])
    if kind <= TORUS:
        return _elementary(kind, f)
    if kind in (EXTRUSION, REVOLUTION):
        return _sweep(arrays, f, kind == EXTRUSION, within)
    if int(f["map_u"]) or int(f["map_v"]):
        raise SurfaceError("a closed form that was stretched: its parameter is no longer an angle")
    spline = _grid(arrays, f)
    if kind == BEZIER:
        return _bezier(f, *spline)
    if kind == BSPLINE:
        return _bspline(f, *spline, within)
    raise SurfaceError("no surface")


def _elementary(kind: int, f: Any) -> Geom_Surface:
    frame = gp_Ax3(point(f["location"]), direction(f["z_axis"]), direction(f["x_axis"]))
    y = frame.YDirection()
    if float(np.dot(f["y_axis"], (y.X(), y.Y(), y.Z()))) < 0.0:
        frame.YReverse()
    r1, r2 = float(f["r1"]), float(f["r2"])
    if kind == PLANE:
        return Geom_Plane(frame)
    if kind == CYLINDER:
        return Geom_CylindricalSurface(frame, r1)
    if kind == CONE:
        return Geom_ConicalSurface(frame, float(f["semi_angle"]), r1)
    return Geom_SphericalSurface(frame, r1) if kind == SPHERE else Geom_ToroidalSurface(frame, r1, r2)


def _grid(arrays: dict[str, Any], f: Any) -> tuple[Floats, Floats, Floats]:
    """Flat knots in u and v, control points (count_u, count_v, 4)."""
    knots, (ub, ue), (vb, ve), (cb, ce) = arrays["knots"], f["knots_u"], f["knots_v"], f["ctrl"]
    ctrl = arrays["ctrl_h"][cb:ce].reshape(int(f["count_u"]), int(f["count_v"]), 4)
    return knots[ub:ue], knots[vb:ve], ctrl


def _poles(ctrl: Floats) -> tuple[TColgp_Array2OfPnt, TColStd_Array2OfReal | None]:
    weights = ctrl[:, :, 3]
    poles = TColgp_Array2OfPnt(1, ctrl.shape[0], 1, ctrl.shape[1])
    for i, row in enumerate((ctrl[:, :, :3] / weights[:, :, None]).tolist(), start=1):
        for j, (x, y, z) in enumerate(row, start=1):
            poles.SetValue(i, j, gp_Pnt(x, y, z))
    if np.ptp(weights) == 0.0:
        return poles, None
    array = TColStd_Array2OfReal(1, ctrl.shape[0], 1, ctrl.shape[1])
    for i, values in enumerate(weights.tolist(), start=1):
        for j, weight in enumerate(values, start=1):
            array.SetValue(i, j, weight)
    return poles, array


def _bezier(f: Any, knots_u: Floats, knots_v: Floats, ctrl: Floats) -> Geom_Surface:
    """Bezier surfaces live over the unit square; the store holds the part that the face needs."""
    ctrl = over_unit(ctrl, float(knots_u[0]), float(knots_u[-1]))
    ctrl = over_unit(ctrl.swapaxes(0, 1), float(knots_v[0]), float(knots_v[-1])).swapaxes(0, 1)
    poles, weights = _poles(ctrl)
    return Geom_BezierSurface(poles) if weights is None else Geom_BezierSurface(poles, weights)


def _bspline(
    f: Any, knots_u: Floats, knots_v: Floats, ctrl: Floats, within: Floats | None
) -> Geom_BSplineSurface:
    (values_u, counts_u), (values_v, counts_v) = distinct(knots_u), distinct(knots_v)
    arguments = (reals(values_u), reals(values_v), integers(counts_u), integers(counts_v),
                 int(f["degree_u"]), int(f["degree_v"]))  # fmt: skip
    poles, weights = _poles(ctrl)
    if weights is None:
        surface = Geom_BSplineSurface(poles, *arguments)
    else:
        surface = Geom_BSplineSurface(poles, weights, *arguments)
    periods = f["period_u"] if f["periodic_u"] else 0.0, f["period_v"] if f["periodic_v"] else 0.0
    whole_u, whole_v = (_is_whole(v, p) for v, p in zip((values_u, values_v), periods, strict=True))
    if within is not None:
        surface.Segment(*_ends(values_u, None if whole_u else within[:, 0]),
                        *_ends(values_v, None if whole_v else within[:, 1]))  # fmt: skip
    if whole_u:
        surface.SetUPeriodic()
    if whole_v:
        surface.SetVPeriodic()
    return surface


def _is_whole(values: Sequence[float], period: float) -> bool:
    """Do the knots span a whole period? Such a spline closes up, and goes on beyond its ends."""
    return period > 0.0 and abs(float(values[-1] - values[0]) - period) <= _FULL * period


def _ends(values: Sequence[float], within: Floats | None) -> tuple[float, float]:
    """The first and the last of the knots, or of the range that is wanted of them."""
    low, high = float(values[0]), float(values[-1])
    return (low, high) if within is None else (max(low, float(within[0])), min(high, float(within[1])))


def _sweep(arrays: dict[str, Any], f: Any, extrusion: bool, within: Floats | None) -> Geom_Surface:
    axis = f["z_axis"]
    if not float(np.dot(axis, axis)) > 0.5:
        raise SurfaceError("a sweep that was stretched: its parameter is no longer a length or an angle")
    conic = arrays["conics"][int(f["conic"])] if int(f["conic"]) >= 0 else None
    profile = _profile(arrays, f, extrusion, conic)
    if isinstance(profile, Geom_BSplineCurve):
        ends = [profile.FirstParameter(), profile.LastParameter()]
        if _is_whole(ends, float(f["period_u"] if extrusion else f["period_v"])):
            profile.SetPeriodic()
        elif within is not None:
            profile.Segment(*_ends(ends, within[:, 0 if extrusion else 1]))
    if extrusion:
        return Geom_SurfaceOfLinearExtrusion(profile, direction(axis))
    return Geom_SurfaceOfRevolution(profile, gp_Ax1(point(f["location"]), direction(axis)))


def _profile(arrays: dict[str, Any], f: Any, extrusion: bool, conic: Any | None) -> Geom_Curve:
    """The curve that is swept, where it stands at v = 0 (extrusion) or u = 0 (revolution)."""
    knots_u, knots_v, ctrl = _grid(arrays, f)
    axis = f["z_axis"]
    if extrusion:
        start = float(knots_v[0])
        points = ctrl[:, 0].copy()
        points[:, :3] -= points[:, 3:] * (start * axis)
        return space_curve(Spline(int(f["degree_u"]), knots_u, points), conic)
    points = _turned(ctrl[0], f["location"], axis, -float(knots_u[0]))
    return space_curve(Spline(int(f["degree_v"]), knots_v, points), conic)


def _turned(points: Floats, location: Floats, axis: Floats, angle: float) -> Floats:
    """Homogeneous points (n, 4) turned about an axis."""
    if angle == 0.0:
        return points
    arm = points[:, :3] - points[:, 3:] * location
    along = np.outer(arm @ axis, axis)
    across = arm - along
    turned = math.cos(angle) * across + math.sin(angle) * np.cross(axis, across)
    return np.concatenate([turned + along + points[:, 3:] * location, points[:, 3:]], axis=1)
