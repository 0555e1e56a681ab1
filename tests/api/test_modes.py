"""Every tracer gives the same picture: to the byte, on all planes."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepLib import BRepLib
from OCP.GCE2d import GCE2d_MakeSegment
from OCP.Geom import Geom_CylindricalSurface
from OCP.gp import gp_Ax3, gp_Pnt2d
from OCP.TopoDS import TopoDS_Face

import trimray

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
NAMES = ("assembly.step", "bracket.brep", "bracket_faces.igs", "cornell_box.step", "patch.step")
NAMES += ("spline_part.step", "stand.stl", "teapot.igs", "teapot.step")
TORTURE = tuple(sorted(f"torture/{p.name}" for p in (SAMPLES / "torture").glob("*.st*p")))


def same(a: trimray.Frame, b: trimray.Frame) -> bool:
    return a.aovs == b.aovs and all(a[name].tobytes() == b[name].tobytes() for name in a)


@pytest.mark.parametrize("name", NAMES + TORTURE)
def test_hybrid_and_standard_are_the_same_to_the_byte(name: str) -> None:
    model = trimray.load(SAMPLES / name)
    size = (17, 13) if "offset" in name else (61, 83)  # those take long
    views = ("iso", (200.0, -30.0), "top") if name in NAMES else ("iso", (200.0, -30.0))
    for projection in ("orthographic", "perspective"):
        for view in views:
            for zoom, samples, threads in ((1.0, 1, 1), (1.0, 4, 2), (7.0, 4, 1)):
                camera = model.camera(size, view=view, projection=projection, zoom=zoom)
                want, got = (
                    model.render(view=camera, samples=samples, mode=mode, threads=threads, aovs=trimray.AOVS)
                    for mode in ("standard", "hybrid")
                )
                assert same(want, got), (view, projection, zoom, samples)


def test_pictures_with_many_samples_are_the_same(sphere: trimray.Model) -> None:
    want, got = (
        sphere.render((33, 20), samples=50, aovs=("color", "face"), mode=mode)
        for mode in ("standard", "hybrid")
    )
    assert same(want, got)


def test_the_reference_gives_the_picture_of_the_others(box: trimray.Model) -> None:
    want, got = (
        box.render((12, 9), view=(30, 20), samples=1, mode=mode, aovs=("color", "face", "instance"))
        for mode in ("reference", "hybrid")
    )
    assert (want["face"] == got["face"]).all() and (want["instance"] == got["instance"]).all()
    assert np.abs(want["color"] - got["color"]).max() < 1e-6


@pytest.mark.parametrize("mode", ["hybrid", "standard"])
def test_time_is_what_the_pixels_took(sphere: trimray.Model, mode: str) -> None:
    start = perf_counter()
    frame = sphere.render((64, 48), samples=1, mode=mode, aovs=("time", "face"), threads=1)  # type: ignore[arg-type]
    elapsed = perf_counter() - start
    time = frame["time"]
    assert time.shape == (48, 64) and time.dtype == np.float32
    assert (time > 0).all()
    blocks = time.reshape(6, 8, 8, 8)
    assert (blocks == blocks[:, :1, :, :1]).all()
    assert 0.0 < time.sum(dtype=np.float64) * 1e-9 <= elapsed
    alone = sphere.render((64, 48), samples=1, mode=mode, aovs="time")["time"]  # type: ignore[arg-type]
    assert (alone > 0).all()


def strip_round_a_cylinder() -> TopoDS_Face:
    """A ribbon of height 2 that winds up a cylinder for one turn and a half."""
    surface = Geom_CylindricalSurface(gp_Ax3(), 5.0)
    corners = [gp_Pnt2d(u, v) for u, v in ((0, 0), (9.4, 3), (9.4, 5), (0, 2))]
    wire = BRepBuilderAPI_MakeWire()
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        wire.Add(BRepBuilderAPI_MakeEdge(GCE2d_MakeSegment(start, end).Value(), surface).Edge())
    face = BRepBuilderAPI_MakeFace(surface, wire.Wire()).Face()
    BRepLib.BuildCurves3d_s(face)
    return face


def test_the_reference_sees_a_face_that_winds_more_than_one_turn() -> None:
    """Its loops stand in the store once more, a period on: images of the point counted them twice."""
    model = trimray.load(strip_round_a_cylinder())
    samples = model.sample(200, seed=4)
    origins, directions = samples.point + 1e-3 * samples.normal, -samples.normal
    for mode in ("standard", "reference"):
        assert (model.cast(origins, directions, tmax=2e-3, mode=mode).face == 0).all(), mode
    beside = samples.point * [1.0, 1.0, 0.0] + [0.0, 0.0, 40.0] + 1e-3 * samples.normal
    assert (model.cast(beside, directions, tmax=2e-3, mode="reference").face == -1).all()
