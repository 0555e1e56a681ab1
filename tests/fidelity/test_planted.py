"""Every planted defect is found, by the sections that can see it, and nothing else is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cadquery as cq
import pytest

import trimray

from . import shapes
from .conftest import named, quick, sections

ALL = {"structure", "topology", "mass", "geometry", "pictures"}


def test_a_face_moved_by_a_ten_thousandth_of_the_size() -> None:
    moved = shapes.plate(shapes.BOX[2] + 1e-4 * shapes.DIAGONAL)
    found = quick(shapes.plate(), moved)
    assert found.verdict == "changed"
    assert sections(found) == {"mass", "geometry", "pictures"}
    worst = named(found, "largest distance of faces")[0]
    assert worst.difference == pytest.approx(1e-4 * shapes.DIAGONAL, rel=1e-6)
    assert any("plane" in f.where for f in named(found, "face off"))


@pytest.mark.parametrize("number", [0, 5])
def test_a_flipped_face(number: int) -> None:
    box = cq.Workplane().box(*shapes.BOX)
    found = quick(shapes.shell_of(box), shapes.shell_of(box, turn=number))
    assert found.verdict == "changed"
    assert sections(found) >= {"geometry", "topology"}
    turned = named(found, "face turned")
    assert {(f.a, f.b) for f in turned} == {(number, number)}
    assert turned[0].difference == pytest.approx(3.14159265, abs=1e-6)
    assert not named(found, "largest distance of faces")


def test_a_lost_hole() -> None:
    box = cq.Workplane().box(*shapes.BOX, centered=False)
    one = box.faces(">Z").workplane(origin=(10, 10, 0)).hole(6)
    found = quick(one, box)
    assert found.verdict == "partial"
    assert sections(found) == {"topology", "mass", "geometry", "pictures"}
    worst = named(found, "largest distance of faces")[0]
    # B fills the hole: its middle is a radius away from A. The middle of A's bore is half the height from B.
    assert 1.5 < worst.b <= 3.0 + 1e-9
    assert 4.5 < worst.a <= 5.0 + 1e-9
    assert {f.a for f in named(found, "faces of kind cylinder")} == {1}


def test_a_changed_color() -> None:
    found = quick(shapes.pair(), shapes.pair(colors=("red", "blue")))
    assert found.verdict == "changed"
    assert sections(found) == {"structure", "pictures"}
    (color,) = named(found, "colour")
    assert (color.a, color.b, color.where) == ("#00ff00", "#0000ff", "pair/peg")
    assert all("in color" in f.reason for f in found.differences() if f.section == "pictures")


def test_a_changed_color_of_one_face() -> None:
    def painted(color: str) -> Any:
        box = cq.Workplane().box(*shapes.BOX)
        assembly = cq.Assembly(name="box")
        assembly.add(box, name="body", color=cq.Color("gray"))
        assembly.objects["body"].addSubshape(box.faces(">Z").val(), color=cq.Color(color))
        return assembly

    found = quick(painted("red"), painted("blue"))
    (color,) = named(found, "colour")
    assert (color.a, color.b) == ("#ff0000", "#0000ff")
    assert "face" in color.where and "plane" in color.where


def test_a_renamed_part() -> None:
    found = quick(shapes.pair(), shapes.pair(names=("base", "pge")))
    assert found.verdict == "changed"
    assert sections(found) == {"structure"}
    (name,) = named(found, "part name")
    assert (name.a, name.b, name.where) == ("peg", "pge", "pair/peg")


def test_a_dropped_instance() -> None:
    found = quick(shapes.pair(), shapes.pair(drop=True))
    assert found.verdict == "partial"
    assert sections(found) == ALL
    assert [f.where for f in named(found, "instance")] == ["pair/peg"]


def test_a_dropped_instance_among_equal_ones() -> None:
    found = quick(shapes.four_pegs(), shapes.four_pegs(drop=True))
    assert found.verdict == "partial"
    (instance,) = named(found, "instance")
    assert instance.reason == "only in A"
    assert not named(found, "transform")


def test_one_of_equal_instances_moved() -> None:
    found = quick(shapes.four_pegs(), shapes.four_pegs(shift=1e-3))
    assert found.verdict == "changed"
    (moved,) = named(found, "transform")
    assert moved.difference == pytest.approx(1e-3)


def test_swapped_transforms() -> None:
    found = quick(shapes.pair(), shapes.pair(places=(60.0, 0.0)))
    assert found.verdict == "changed"
    assert {f.where for f in named(found, "transform")} == {"pair/base", "pair/peg"}


def test_swapped_transforms_of_equal_parts() -> None:
    """Nothing but the names tells."""

    def pegs(first: str, second: str) -> Any:
        peg = cq.Workplane().cylinder(20, 4)
        assembly = cq.Assembly(name="pegs")
        assembly.add(peg, name=first)
        assembly.add(peg, name=second, loc=cq.Location(cq.Vector(0, 0, 50)))
        return assembly

    found = quick(pegs("left", "right"), pegs("right", "left"))
    assert found.verdict == "changed"
    assert sections(found) == {"structure"}
    assert {f.difference for f in named(found, "transform")} == {50.0}


def test_inch_against_millimetre(tmp_path: Path, load_here: Callable[[Path], trimray.Model]) -> None:
    one, other = tmp_path / "mm.step", tmp_path / "inch.step"
    cq.exporters.export(shapes.plate(), str(one))
    cq.exporters.export(shapes.plate(), str(other), unit="INCH", outputUnit="INCH")
    found = quick(load_here(one), load_here(other))
    assert found.verdict == "changed"
    (unit,) = named(found, "unit")
    assert (unit.a, unit.b) == ("mm", "inch")
    (bounds,) = named(found, "bounds")
    assert "as if mm had been read as inch" in bounds.reason


def test_one_knot_changed() -> None:
    found = quick(shapes.spline_face(0.5), shapes.spline_face(0.501))
    assert found.verdict == "changed"
    assert "geometry" in sections(found)
    assert not {"structure", "topology"} & sections(found)


def test_a_degraded_p_curve() -> None:
    found = quick(shapes.plate().val(), shapes.degraded(shapes.plate(), 2e-3))
    assert found.verdict == "changed"
    edges = named(found, "p-curve off its edge")
    assert 1 <= len(edges) <= 2  # the seam may end there
    assert edges[0].difference == pytest.approx(2e-3, rel=0.5)
    assert sections(found) == {"geometry"}


def test_a_missing_face() -> None:
    found = quick(shapes.shell_of(shapes.plate()), shapes.shell_of(shapes.plate(), drop=3))
    assert found.verdict == "partial"
    assert sections(found) >= {"topology", "mass", "geometry"}
    assert named(found, "free edges")
    assert {f.a for f in named(found, "face off")} == {3}
