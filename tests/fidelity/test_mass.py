"""Mass properties of two models: precise, and neither deceived by p-curves nor deaf to what they hide."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

import trimray
from trimray.fidelity import Side, read
from trimray.fidelity.mass import compare_mass
from trimray.fidelity.strips import changed_strips
from trimray.fidelity.tolerances import PROFILES

STRICT = PROFILES["strict"]


def drilled(radius: float = 3.0) -> cq.Workplane:
    return cq.Workplane().box(40, 30, 5).faces(">Z").workplane().hole(2 * radius)


@pytest.fixture
def plate() -> Side:
    return read(drilled())


def astray(side: Side, by: float) -> Side:
    """The same, with p-curves that stray from every edge by so much more, mm."""
    other = Side(side.name, side.model)
    edges = side.arrays["edges"].copy()
    edges["band"] += 1.5 * by
    other.__dict__["arrays"] = side.arrays | {"edges": edges}
    return other


def with_area(side: Side, more: float) -> Side:
    """The same, with a larger area."""
    other = Side(side.name, side.model)
    other.__dict__["arrays"] = side.arrays
    other.__dict__["mass"] = replace(side.mass, area=side.mass.area * (1 + more))
    return other


def test_models_alone_are_known_as_well_as_files() -> None:
    a, b = read(trimray.load(drilled())), read(drilled(3.0 + 1e-7))
    volume, area, *_ = compare_mass(a, b, STRICT)
    assert volume.a == pytest.approx(5 * (1200 - 9 * np.pi), rel=1e-13)
    assert not volume.same and volume.difference == pytest.approx(-30e-7 * np.pi, rel=1e-4)
    assert volume.tolerance == pytest.approx(1e-9 * volume.a, rel=1e-3)
    assert area.same  # by 6e-7 mm² of 3000 mm²


def test_what_is_the_same_is_the_same(plate: Side) -> None:
    assert all(finding.same for finding in compare_mass(plate, read(drilled()), STRICT))


def test_other_p_curves_may_change_an_area(plate: Side) -> None:
    """By no more than their strips, and the finding says so."""
    strips, edges = changed_strips(plate, astray(plate, 1e-6))
    lengths = 4 * (40 + 30 + 5) + 2 * (2 * np.pi * 3) + 5
    assert edges == 15
    assert 2e-6 * lengths <= strips < 2.3e-6 * lengths
    inside = astray(plate, 1e-6)
    inside.__dict__["mass"] = with_area(plate, 0.9 * strips / plate.mass.area).mass
    _, area, *_ = compare_mass(plate, inside, STRICT)
    assert area.same and area.reason == "15 edges have other p-curves"
    assert area.tolerance is not None and area.tolerance > strips
    inside.__dict__["mass"] = with_area(plate, 1.1 * strips / plate.mass.area).mass
    _, area, *_ = compare_mass(plate, inside, STRICT)
    assert not area.same and area.reason == "" and area.tolerance < strips


def test_p_curves_that_stray_alike_excuse_nothing(plate: Side) -> None:
    a = astray(plate, 1e-3)
    b = with_area(a, 1e-7)
    assert changed_strips(a, b) == (0.0, 0)
    assert changed_strips(a, astray(plate, 1.0005e-3))[1] == 15  # nearly alike is not the same
    _, area, *_ = compare_mass(a, b, STRICT)
    assert not area.same and area.reason == ""
