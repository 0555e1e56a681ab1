"""Real models: their store loses nothing, and a defect planted into one is found. The full run is
`scripts/verify fidelity|defects`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.verify import fidelity, planted
from tests.verify.fidelity_exceptions import KNOWN, known_for
from trimray.fidelity import Finding, compare, read

from .conftest import sections

FILES = [
    "CadQuery+cadquery/red_cube_blue_cylinder.step",
    "fougue+mayo/#332_file.stp",
    "stepcode+stepcode/TAIL_MIDDLE_PART.stp",
]
MODEL = "printable_case_full.stp"
ASSEMBLY = "CadQuery+cadquery/red_cube_blue_cylinder.step"


@pytest.mark.corpus
@pytest.mark.parametrize("name", FILES)
def test_the_store_of_a_real_model_loses_nothing(name: str, models_dir: Path) -> None:
    found = fidelity.check(models_dir / name, "step", points=1000, start="spawn")
    assert found.failures == ()
    assert found.verdict == "complete"
    assert found.distance <= 1e-9
    assert found.pixels == 0
    assert found.volume <= 1e-9 and found.area <= 1e-9


@pytest.mark.corpus
def test_defects_planted_into_a_real_model_are_found(models_dir: Path, tmp_path: Path) -> None:
    a = read(models_dir / ASSEMBLY)
    for name in ("moved face", "changed colour", "dropped instance", "inch for millimetre"):
        defect = next(one for one in planted.DEFECTS if one.name == name)
        target = tmp_path / "b.step"
        planted.plant(a.sound, defect, target, a.diagonal)
        found = compare(a, read(target, cache=False), points=1000, images=False, views=("iso",))
        assert sections(found) >= defect.sections, name


def test_an_exception_explains_its_findings_alone() -> None:
    known = next(one for one in KNOWN if one.model == MODEL and one.via == "step")
    finding = Finding("geometry", "p-curve off its edge", 1e-7, 2e-8, False, "mm", 1e-7, 1e-8)
    assert known_for(MODEL, "step", finding) is known
    assert known_for(MODEL, "brep", finding) is None
    assert known_for("other.igs", "step", finding) is None
    assert known_for(MODEL, "step", replace(finding, difference=5e-4)) is None
    assert known_for(MODEL, "step", replace(finding, section="mass")) is None
    assert known_for(MODEL, "step", replace(finding, name="face off")) is None
