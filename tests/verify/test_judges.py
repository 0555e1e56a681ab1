"""The judges at a size that fits a test run; scripts/verify runs them in full."""

from __future__ import annotations

from pathlib import Path

import pytest

import trimray

from . import closed_forms, contact_sheet, parity, reference

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
