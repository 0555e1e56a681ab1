"""Real models: through the store to STEP and back, with all that the file format can hold."""

from __future__ import annotations

import numpy as np
import pytest

from trimray.exporter import write
from trimray.exporter.files import write_file
from trimray.exporter.from_store import build_parts, rebuild
from trimray.importer import occt
from trimray.importer.build_store import build_store

from .measure import counts, deviation, sources_of
from .measure import plain_area as area

MODELS = [
    "CadQuery+cadquery/red_cube_blue_cylinder.step",
    "stepcode+stepcode/TAIL_MIDDLE_PART.stp",
    "Creality3DPrinting+Ender-3/M2X10杯头.step",
    "DLR-SC+tigl/nacelle.stp",
    "BRL-CAD+brlcad/wing128.igs",
]


@pytest.mark.corpus
@pytest.mark.parametrize("name", MODELS)
def test_a_model_goes_through_the_store_to_step_and_back(read_here, models_dir, tmp_path, name):
    before = read_here(models_dir / name)
    store = build_store(before)
    occt.initialize()
    write_file(
        rebuild(store.arrays(), store.meta), str(tmp_path / "out.step"), "step", "ap242", faithful=True
    )
    after = read_here(tmp_path / "out.step")
    again = build_store(after)
    assert again.face_kinds() == store.face_kinds()
    assert [n.name for n in after.tree] == [n.name for n in before.tree]
    assert np.allclose(after.instance_placements, before.instance_placements, atol=1e-10)
    assert np.allclose(again.arrays()["faces"]["color"], store.arrays()["faces"]["color"], atol=1e-5)
    assert after.unit == before.unit
    arrays = store.arrays()
    made = zip(build_parts(again.arrays()), build_parts(arrays), sources_of(before), strict=True)
    for part, first, source in made:
        # Files hold 13 digits.
        assert deviation(arrays, part, source, points=10) <= 1e-11
        assert counts(part.shape) == counts(source)
        assert area(part.shape) == pytest.approx(area(first.shape), rel=1e-9)


@pytest.mark.corpus
def test_tolerances_that_opencascade_cannot_write_are_left_out_and_listed(models_dir):
    written = write(models_dir / "yuechen-li-dev+Aetheris/nist_ctc_01_asme1_ap242-e1.stp")
    assert written.data is not None and written.data.endswith(b"END-ISO-10303-21;\n")
    assert ["PMI" in reason for _, reason in written.issues] == [True]
