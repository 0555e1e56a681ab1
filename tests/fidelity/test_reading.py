"""Sides: what is read of a file."""

from __future__ import annotations

from pathlib import Path

from trimray.fidelity import read

from .conftest import quick


def test_a_side_is_read_once(samples_dir: Path) -> None:
    side = read(samples_dir / "bracket.step")
    assert read(side) is side
    found = quick(side, samples_dir / "bracket.step", pictures=False)
    assert found.verdict == "complete"
    (volume,) = (f for f in found.findings if f.name == "volume")
    assert volume.a == volume.b == side.mass.volume
    assert volume.a is not None and volume.tolerance is not None
    assert 1e-6 * volume.a <= volume.tolerance < 1.001e-6 * volume.a


def test_triangles_are_read_as_well(samples_dir: Path) -> None:
    side = read(samples_dir / "stand.stl")
    assert not side.error
    assert quick(side, side).verdict == "complete"
