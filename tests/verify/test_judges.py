"""The judges at a size that fits a test run; scripts/verify runs them in full."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trimray

from . import brep_mesh, closed_forms, contact_sheet, mesh, parity, reference

SAMPLES = contact_sheet.models_in(Path(__file__).resolve().parents[2] / "samples")
# Surfaces without thickness; everything else that we made is closed.
OPEN = {"patch", "cornell_box", "teapot", "offset_surface"}
# Real models of every kind that the reference tracer can judge in a few seconds.
REAL = (
    "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
    "vrsys+gpucast/part.igs",
    "stepcode+stepcode/as1-oc-214.stp",
    "AngelLM+Thor/Art2BodyA.step",
    "pypi-pyiges/impeller.igs",
    "DLR-SC+tigl/nacelle.stp",
    "Open-Cascade-SAS+OCCT/hammer.iges",
    "derived/occt_Motor-c.step",
)
REAL_CLOSED = (
    "BRL-CAD+brlcad/NIST_MBE_PMI_2.stp",
    "stepcode+stepcode/as1-oc-214.stp",
    "AngelLM+Thor/Art2BodyA.step",
    "derived/occt_Motor-c.step",
    "VoronDesign+Voron-0/Fysetc_5i_LCD.iges",
)


def _agree(result: reference.Result) -> None:
    """No unexplained difference, and the explanations that lean on the file's own tolerance are rare."""
    assert result.hits > 0
    assert result.unexplained == []
    assert result.knife_edge + result.band <= 0.005 * result.rays, result


@pytest.mark.parametrize("scene", list(closed_forms.scenes()), ids=lambda s: s.name)
def test_first_hits_equal_the_closed_forms(scene: closed_forms.Scene) -> None:
    result = closed_forms.check(scene, 4 if "torus" in scene.name else 16)
    assert result.rays > 400
    assert result.wrong == 0, result


@pytest.mark.parametrize("file", SAMPLES, ids=lambda p: p.stem)
def test_closed_samples_are_crossed_an_even_number_of_times(file: Path) -> None:
    result = parity.check(trimray.load(file), 2)
    if file.stem in OPEN:
        assert result.solids == 0
        return
    assert result.rays > 0
    assert result.odd == 0, result


@pytest.mark.parametrize("file", SAMPLES, ids=lambda p: p.stem)
def test_fast_and_reference_tracer_agree_on_samples(file: Path) -> None:
    _agree(reference.check(trimray.load(file), 8))


@pytest.mark.corpus
@pytest.mark.parametrize("name", REAL)
def test_fast_and_reference_tracer_agree_on_real_models(models_dir: Path, name: str) -> None:
    _agree(reference.check(trimray.load(models_dir / name), 4))


@pytest.mark.corpus
@pytest.mark.parametrize("name", REAL_CLOSED)
def test_closed_real_models_are_crossed_an_even_number_of_times(models_dir: Path, name: str) -> None:
    result = parity.check(trimray.load(models_dir / name), 1)
    assert result.rays > 0, "its shells are closed in the file"
    assert result.odd == 0, result


def _keeps_its_promises(model: trimray.Model, fraction: float, most_triangles: int) -> None:
    unknown = [float("nan")] * len(model._core.prototype_faces())
    result = mesh.check_ours(model, unknown, fraction * mesh.diagonal(model), most_triangles)
    assert result.triangles > 0
    assert result.measured > 0
    assert result.wrong == 0, result


@pytest.mark.parametrize("fraction", [1e-2, 1e-3])
@pytest.mark.parametrize("file", SAMPLES, ids=lambda p: p.stem)
def test_meshes_of_samples_are_watertight_and_as_near_as_proven(file: Path, fraction: float) -> None:
    _keeps_its_promises(trimray.load(file), fraction, 2000)


@pytest.mark.corpus
@pytest.mark.parametrize("name", REAL)
def test_meshes_of_real_models_are_watertight_and_as_near_as_proven(models_dir: Path, name: str) -> None:
    _keeps_its_promises(trimray.load(models_dir / name), 1e-2, 2000)


def test_a_mesh_has_the_volume_of_its_solid(samples_dir: Path) -> None:
    """Against OpenCascade's integral, as in the full run; its own mesh passes through the same hands."""
    file = samples_dir / "bracket.step"
    model = trimray.load(file)
    ((_, ours, theirs),) = mesh.check(file, model, [1e-2], time_limit=60)
    assert isinstance(ours, mesh.Judgement)
    assert isinstance(theirs, mesh.Judgement), theirs
    for judged in (ours, theirs):
        assert judged.open == judged.non_manifold == judged.holes == 0, judged
        assert judged.negative == 0
        assert 0 < judged.volume <= 1


def test_the_judge_of_meshes_sees_what_is_wrong(samples_dir: Path) -> None:
    model = trimray.load(samples_dir / "bracket.step")
    deviation = 1e-2 * mesh.diagonal(model)
    (good,), _ = mesh.tessellate(model, deviation)

    def judged(**change: object) -> mesh.Judgement:
        return mesh.judge(model, [replace(good, **change)], [float("nan")], deviation)  # type: ignore[arg-type]

    assert good.deviation is not None
    moved = good.vertices.copy()
    moved[good.triangles[0, 0]] += 5 * deviation
    assert judged(vertices=moved).violations > 0
    lost = {
        name: np.ascontiguousarray(getattr(good, name)[1:])
        for name in ("triangles", "corner_uv", "face", "deviation")
    }
    one_less = judged(**lost)
    assert one_less.open == 3
    assert one_less.holes == 3
    turned = good.triangles.copy()
    turned[0] = turned[0, ::-1]
    assert judged(triangles=turned).non_manifold == 3
    assert judged(deviation=0.1 * good.deviation).violations > 0
    assert judged(deviation=good.deviation + 2 * deviation).over_request == len(good.triangles)
    whole_face_lost = good.face != good.face[0]
    kept = {
        name: np.ascontiguousarray(getattr(good, name)[whole_face_lost])
        for name in ("triangles", "corner_uv", "face", "deviation")
    }
    assert judged(**kept).issues == 1


def test_brep_meshs_child_may_die(tmp_path: Path) -> None:
    broken = tmp_path / "broken.step"
    broken.write_text("ISO-10303-21;")
    (result,) = brep_mesh.brep_meshes(broken, [0.1], 60)
    assert isinstance(result, str)
