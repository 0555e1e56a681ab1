"""From the store's curve pieces to OpenCascade's curves: conics and lines by their formula, all else as the
B-spline that the Bezier pieces are, pole by pole.

A curve keeps the parameter of the file's edge, so that p-curves and edge agree at equal parameters as well
as they did there.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_Circle,
    Geom_Curve,
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_Line,
    Geom_Parabola,
)
from OCP.Geom2d import (
    Geom2d_BSplineCurve,
    Geom2d_Circle,
    Geom2d_Curve,
    Geom2d_Ellipse,
    Geom2d_Hyperbola,
    Geom2d_Line,
    Geom2d_Parabola,
)
from OCP.gp import gp_Ax2, gp_Ax22d, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d
from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal

from .splines import Floats, Spline, distinct

CIRCLE, ELLIPSE, PARABOLA, HYPERBOLA = range(4)  # store.h, ConicKind
_UNIT = 1e-12  # how far from 1 the speed of a line may be


def reals(values: Sequence[float]) -> TColStd_Array1OfReal:
    array = TColStd_Array1OfReal(1, len(values))
    for i, value in enumerate(values, start=1):
        array.SetValue(i, value)
    return array


def integers(values: Sequence[int]) -> TColStd_Array1OfInteger:
    array = TColStd_Array1OfInteger(1, len(values))
    for i, value in enumerate(values, start=1):
        array.SetValue(i, value)
    return array


def direction(v: Any) -> gp_Dir:
    return gp_Dir(float(v[0]), float(v[1]), float(v[2]))


def point(v: Any) -> gp_Pnt:
    return gp_Pnt(float(v[0]), float(v[1]), float(v[2]))


def space_curve(spline: Spline, conic: Any | None) -> Geom_Curve:
    """An edge's curve in space. conic: its record of conics, None for what is no conic."""
    if conic is not None:
        return space_conic(conic)
    line = _line(spline)
    if line is not None:
        return Geom_Line(point(line[0]), direction(line[1]))
    return space_spline(spline)


def space_conic(conic: Any) -> Geom_Curve:
    x, y = conic["x_axis"], conic["y_axis"]
    frame = gp_Ax2(point(conic["location"]), direction(np.cross(x, y)), direction(x))
    kind, r1, r2 = int(conic["kind"]), float(conic["r1"]), float(conic["r2"])
    if kind == CIRCLE:
        return Geom_Circle(frame, r1)
    if kind == ELLIPSE:
        return Geom_Ellipse(frame, r1, r2)
    return Geom_Parabola(frame, r1) if kind == PARABOLA else Geom_Hyperbola(frame, r1, r2)


def space_spline(spline: Spline) -> Geom_BSplineCurve:
    values, counts = distinct(spline.knots)
    weights = spline.ctrl_h[:, 3]
    poles = TColgp_Array1OfPnt(1, len(weights))
    for i, (x, y, z) in enumerate((spline.ctrl_h[:, :3] / weights[:, None]).tolist(), start=1):
        poles.SetValue(i, gp_Pnt(x, y, z))
    arguments = reals(values), integers(counts), spline.degree
    if np.ptp(weights) == 0.0:
        return Geom_BSplineCurve(poles, *arguments)
    return Geom_BSplineCurve(poles, reals(weights.tolist()), *arguments)


def flat_curve(spline: Spline, conic: Any | None) -> Geom2d_Curve:
    """A p-curve; conic as in space_curve, in uv."""
    if conic is not None:
        return _flat_conic(conic)
    line = _line(spline)
    if line is not None:
        return Geom2d_Line(gp_Pnt2d(*line[0].tolist()), gp_Dir2d(*line[1].tolist()))
    values, counts = distinct(spline.knots)
    weights = spline.ctrl_h[:, 2]
    poles = TColgp_Array1OfPnt2d(1, len(weights))
    for i, (u, v) in enumerate((spline.ctrl_h[:, :2] / weights[:, None]).tolist(), start=1):
        poles.SetValue(i, gp_Pnt2d(u, v))
    arguments = reals(values), integers(counts), spline.degree
    if np.ptp(weights) == 0.0:
        return Geom2d_BSplineCurve(poles, *arguments)
    return Geom2d_BSplineCurve(poles, reals(weights.tolist()), *arguments)


def _flat_conic(conic: Any) -> Geom2d_Curve:
    (x0, x1, _), (y0, y1, _) = conic["x_axis"].tolist(), conic["y_axis"].tolist()
    at = gp_Pnt2d(*conic["location"][:2].tolist())
    frame = gp_Ax22d(at, gp_Dir2d(x0, x1), gp_Dir2d(y0, y1))
    kind, r1, r2 = int(conic["kind"]), float(conic["r1"]), float(conic["r2"])
    if kind == CIRCLE:
        return Geom2d_Circle(frame, r1)
    if kind == ELLIPSE:
        return Geom2d_Ellipse(frame, r1, r2)
    return Geom2d_Parabola(frame, r1) if kind == PARABOLA else Geom2d_Hyperbola(frame, r1, r2)


def _line(spline: Spline) -> tuple[Floats, Floats] | None:
    """Point at the parameter 0 and direction of a straight spline of unit speed."""
    if spline.degree != 1 or len(spline.ctrl_h) != 2 or np.ptp(spline.ctrl_h[:, -1]) != 0.0:
        return None
    first, last = spline.ctrl_h[:, :-1] / spline.ctrl_h[:, -1:]
    width = spline.last - spline.first
    length = float(np.linalg.norm(last - first))
    # Of a short piece far away, the difference of its ends knows the length no better than this.
    rounding = 4e-16 * (float(np.abs(spline.ctrl_h).max()) + abs(spline.last) + abs(spline.first))
    if length == 0.0 or abs(length - width) > _UNIT * width + rounding:
        return None
    along = (last - first) / length
    return first - spline.first * along, along
