"""The B-rep that is made from a store alone is the one that the store was made from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_Circle, Geom_RectangularTrimmedSurface, Geom_SurfaceOfRevolution
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt

import trimray
from trimray.exporter.files import write_file
from trimray.exporter.from_store import build_parts, rebuild
from trimray.importer.build_store import build_store

from .measure import counts, deviation, is_valid, sources_of, volume_and_area

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
FILES = sorted(
    path.relative_to(SAMPLES).as_posix()
    for pattern in ("*.step", "*.igs", "*.brep", "torture/*.step")
    for path in SAMPLES.glob(pattern)
)


@pytest.mark.parametrize("name", FILES)
def test_a_sample_comes_back_from_its_store(read_here, name):
    model = read_here(SAMPLES / name)
    arrays = build_store(model).arrays()
    parts, sources = build_parts(arrays), sources_of(model)
    assert [issue for part in parts for issue in part.issues] == []
    for part, source in zip(parts, sources, strict=True):
        assert deviation(arrays, part, source, points=12) <= 1e-12
        assert counts(part.shape) == counts(source)
        assert is_valid(part.shape) or not is_valid(source)
        (volume, area), (volume0, area0) = volume_and_area(part.shape), volume_and_area(source)
        assert area == pytest.approx(area0, rel=1e-9)
        assert volume == pytest.approx(volume0, rel=1e-9, abs=1e-9 * area0**1.5)


@pytest.mark.parametrize("name", ["bracket.step", "torture/hole_touches_seam.step", "torture/pole_cut.step"])
def test_opencascades_own_format_loses_nothing(read_here, tmp_path, name):
    """What STEP files lose is STEP's loss: here even edges that no reader would make again come back."""
    store = build_store(read_here(SAMPLES / name))
    arrays = store.arrays()
    write_file(rebuild(arrays, store.meta), str(tmp_path / "out.brep"), "brep", "ap242")
    model = read_here(tmp_path / "out.brep")
    again = build_store(model).arrays()
    for array in ("faces", "loops", "coedges", "edges", "vertices", "shells"):
        assert len(again[array]) == len(arrays[array])
    for field in ("kind", "basis", "r1", "r2", "semi_angle"):
        assert np.allclose(again["surfaces"][field], arrays["surfaces"][field], rtol=1e-14)
    (part,) = build_parts(arrays)
    assert deviation(arrays, part, sources_of(model)[0], points=12) <= 1e-14


@pytest.mark.parametrize("kind", ["revolution", "bspline"])
def test_a_spline_that_closes_without_a_period_keeps_its_seam(tmp_path, kind):
    """The store continues splines beyond their ends, where this one would run on beside its beginning: a
    STEP file of that has no seam, and its reader finds the face inside out."""
    circle = Geom_Circle(gp_Ax2(gp_Pnt(20, 0, 0), gp_Dir(0, 1, 0)), 5.0)
    profile = GeomConvert.CurveToBSplineCurve_s(circle)
    profile.SetNotPeriodic()
    ends = profile.FirstParameter(), profile.LastParameter()
    surface = Geom_SurfaceOfRevolution(profile, gp_Ax1(gp_Pnt(), gp_Dir(0, 0, 1)))
    face = BRepBuilderAPI_MakeFace(surface, 0.0, 1.5, *ends, 1e-7).Face()
    if kind == "bspline":
        spline = GeomConvert.SurfaceToBSplineSurface_s(
            Geom_RectangularTrimmedSurface(surface, 0.0, 1.5, *ends)
        )
        assert not spline.IsVPeriodic()
        face = BRepBuilderAPI_MakeFace(spline, 1e-7).Face()
    store = trimray.load(face)._core
    write_file(rebuild(store.arrays(), store.meta), str(tmp_path / "out.step"), "step", "ap242")
    again = trimray.load(tmp_path / "out.step", cache=False)
    assert [face.status for face in again.faces] == ["ok"]
    assert again.bounds == pytest.approx(trimray.load(face).bounds, abs=1e-6)
