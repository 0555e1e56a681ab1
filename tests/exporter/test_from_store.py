"""The B-rep that is made from a store alone is the one that the store was made from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from trimray.exporter.files import write_file
from trimray.exporter.from_store import build_parts, rebuild

from .measure import counts, deviation, is_valid, sources_of, store_of, volume_and_area

SAMPLES = Path(__file__).resolve().parents[2] / "samples"
FILES = sorted(
    path.relative_to(SAMPLES).as_posix()
    for pattern in ("*.step", "*.igs", "*.brep", "torture/*.step")
    for path in SAMPLES.glob(pattern)
)


@pytest.mark.parametrize("name", FILES)
def test_a_sample_comes_back_from_its_store(read_here, name):
    model = read_here(SAMPLES / name)
    arrays = store_of(model).arrays()
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
    store = store_of(read_here(SAMPLES / name))
    arrays = store.arrays()
    write_file(rebuild(arrays, store.meta), str(tmp_path / "out.brep"), "brep", "ap242")
    model = read_here(tmp_path / "out.brep")
    again = store_of(model).arrays()
    for array in ("faces", "loops", "coedges", "edges", "vertices", "shells"):
        assert len(again[array]) == len(arrays[array])
    for field in ("kind", "basis", "r1", "r2", "semi_angle"):
        assert np.allclose(again["surfaces"][field], arrays["surfaces"][field], rtol=1e-14)
    (part,) = build_parts(arrays)
    assert deviation(arrays, part, sources_of(model)[0], points=12) <= 1e-14
