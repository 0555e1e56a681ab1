"""Sides: what is read of a file, and in how many processes."""

from __future__ import annotations

from pathlib import Path

import pytest

import trimray
from trimray.fidelity import read

from . import shapes
from .conftest import quick


def test_a_file_is_inspected_beside_the_model(samples_dir: Path) -> None:
    side = read(samples_dir / "bracket.step")
    assert side.inspection is not None
    assert side.inspection.mass.volume == pytest.approx(43243.7865, rel=1e-8)
    found = quick(side, samples_dir / "bracket.step", pictures=False)
    assert found.verdict == "complete"
    (volume,) = (f for f in found.findings if f.name == "volume")
    assert volume.a == volume.b == side.inspection.mass.volume
    assert volume.tolerance < 1.01e-6 * volume.a + 2 * (
        side.inspection.mass.volume_error + side.inspection.mass.volume_noise
    )


def test_a_model_alone_is_measured_by_its_mesh() -> None:
    side = read(trimray.load(shapes.plate()))
    assert side.inspection is None
    exact = read(shapes.plate()).inspection
    assert exact is not None
    found = quick(side, shapes.plate(), pictures=False)
    assert found.verdict == "complete"
    (volume,) = (f for f in found.findings if f.name == "volume")
    assert volume.b == pytest.approx(exact.mass.volume)
    assert 0.0 < abs(volume.difference) <= volume.tolerance < 0.05 * volume.b


def test_triangles_need_no_inspection(samples_dir: Path) -> None:
    side = read(samples_dir / "stand.stl")
    assert side.inspection is None and not side.error
    assert quick(side, side).verdict == "complete"
