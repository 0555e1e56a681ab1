"""What a comparison comes to: complete, changed, partial, empty, failed."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import cadquery as cq
import pytest

import trimray
from trimray.fidelity import PROFILES, compare, read

from . import shapes
from .conftest import quick

ORDER = ["file", "structure", "topology", "mass", "geometry", "pictures"]


def test_every_section_speaks_even_if_nothing_differs() -> None:
    found = quick(shapes.pair(), shapes.pair())
    assert found.verdict == "complete" and not found.differences() and not found.error
    assert list(dict.fromkeys(f.section for f in found.findings)) == ORDER
    measured = [f for f in found.findings if f.section in ("mass", "geometry")]
    assert all(f.tolerance is not None and f.difference is not None for f in measured)
    assert set(found.seconds) == {"read a", "read b", *ORDER}


def test_it_can_be_written_as_json() -> None:
    found = quick(shapes.plate(), shapes.pair())
    for picture in found.pictures:
        assert picture.a == b""
    facts = asdict(found)
    del facts["pictures"]
    assert json.loads(json.dumps(facts))["verdict"] == "partial"


def test_equal_seeds_give_equal_findings() -> None:
    one, two = (quick(shapes.plate(), shapes.plate(10.5), seed=3) for _ in range(2))
    assert one.findings == two.findings
    other = quick(shapes.plate(), shapes.plate(10.5), seed=4)
    assert one.findings != other.findings


def test_what_cannot_be_read_is_a_verdict(tmp_path: Path) -> None:
    found = quick(shapes.plate(), tmp_path / "none.step")
    assert found.verdict == "failed"
    assert "none.step: No such file" in found.error
    assert found.findings == ()
    assert quick(tmp_path / "none.step", shapes.plate()).verdict == "failed"


def test_a_shape_without_faces_is_empty() -> None:
    found = quick(shapes.plate(), cq.Workplane().circle(3))
    assert found.verdict == "empty"
    assert "no faces" in found.error


def test_profiles_decide() -> None:
    plate, other = shapes.plate(), shapes.plate(shapes.BOX[2] + 1e-5 * shapes.DIAGONAL)
    assert quick(plate, other, profile="lenient").verdict == "complete"
    assert quick(plate, other, profile="default").verdict == "changed"
    assert quick(plate, other, profile="strict").verdict == "changed"
    assert set(PROFILES) == {"strict", "default", "lenient"}


def test_usage_errors() -> None:
    with pytest.raises(trimray.UsageError, match="profile"):
        compare(shapes.plate(), shapes.plate(), profile="loose")
    with pytest.raises(trimray.UsageError, match="points"):
        compare(shapes.plate(), shapes.plate(), points=0)
    with pytest.raises(trimray.UsageError):
        compare(shapes.plate(), 7)


def test_sides_are_read_once_and_used_again() -> None:
    side = read(shapes.plate(), name="the plate")
    assert read(side) is side
    found = quick(side, trimray.load(shapes.plate()))
    assert found.verdict == "complete"
    assert found.a == "the plate"


def test_it_is_a_part_of_the_public_package() -> None:
    assert trimray.compare is compare
