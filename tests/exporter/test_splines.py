"""Bezier pieces of a spline become that spline again."""

from __future__ import annotations

import numpy as np
import pytest

from trimray.exporter.splines import CurveError, Spline, _cut, _smooth, joined, over_unit


def clamped(random, degree, spans, multiplicity=1):
    ends = np.concatenate([[0.0], np.cumsum(0.5 + random.random(spans))])
    counts = [degree + 1, *[multiplicity] * (spans - 1), degree + 1]
    knots = np.repeat(ends, counts)
    ctrl = random.random((len(knots) - degree - 1, 4)) + 0.5
    return Spline(degree, knots, ctrl), ends


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
def test_a_spline_that_was_cut_gets_its_knots_back(degree):
    random = np.random.default_rng(degree)
    for multiplicity in {1, max(1, degree - 1), degree}:
        spline, ends = clamped(random, degree, 9, multiplicity)
        again = _smooth(degree, ends.tolist(), list(_cut(spline, ends)))
        assert np.array_equal(again.knots, spline.knots)
        assert np.abs(_cut(again, ends) - _cut(spline, ends)).max() <= 1e-13


def test_a_corner_stays_a_corner():
    parts = [np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]])]
    cubic = [np.array([p[0], (2 * p[0] + p[1]) / 3, (p[0] + 2 * p[1]) / 3, p[1]]) for p in parts]
    again = _smooth(3, [0.0, 1.0, 2.0], cubic)
    assert again.knots.tolist() == [0.0] * 4 + [1.0] * 3 + [2.0] * 4


def test_weights_that_are_equal_stay_equal():
    random = np.random.default_rng(3)
    spline, ends = clamped(random, 3, 6)
    spline.ctrl_h[:, -1] = 1.0
    again = _smooth(3, ends.tolist(), [np.array(p) for p in _cut(spline, ends) / [1, 1, 1, 1]])
    assert np.ptp(again.ctrl_h[:, -1]) < 1e-15


def test_a_bezier_form_moves_to_the_unit_interval():
    random = np.random.default_rng(4)
    ctrl = random.random((5, 3))
    first, last = -0.01, 1.01
    wide = _cut(Spline(4, np.repeat([0.0, 1.0], 5), over_unit(ctrl, first, last)), np.array([0.0, 1.0]))[0]
    middle = 0.5 * (first + last)

    def at(points, t):
        while len(points) > 1:
            points = (1 - t) * points[:-1] + t * points[1:]
        return points[0]

    assert at(wide, middle) == pytest.approx(at(ctrl, 0.5), abs=1e-14)


def test_pieces_that_are_no_one_curve_are_refused():
    record = [("ctrl", np.int32, (2,)), ("t0", np.float64), ("t1", np.float64)]
    for ends, reason in (((1.5, 1.2), "a gap"), ((1.0, 0.5), "do not follow")):
        pieces = np.array([((0, 2), 0.0, 1.0), ((2, 4), *ends)], dtype=record)
        with pytest.raises(CurveError, match=reason):
            joined(pieces, np.ones((4, 3)))
