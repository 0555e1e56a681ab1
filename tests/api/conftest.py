"""Models that the tests of the API look at; their closed forms are known."""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import pytest

import trimray

CENTER, RADIUS = (3.0, -4.0, 5.0), 10.0
BOX = (10.0, 20.0, 30.0)  # from the origin


@pytest.fixture(scope="session")
def sphere() -> trimray.Model:
    return trimray.load(cq.Workplane().sphere(RADIUS).translate(CENTER))


@pytest.fixture(scope="session")
def box() -> trimray.Model:
    return trimray.load(cq.Workplane().box(*BOX, centered=False))


@pytest.fixture(scope="session")
def box_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("models") / "box.step"
    cq.exporters.export(cq.Workplane().box(*BOX, centered=False), str(path))
    return path


@pytest.fixture(scope="session")
def assembly() -> trimray.Model:
    """A red box at the origin and a green one at z = 100."""
    part = cq.Workplane().box(*BOX, centered=False)
    a = cq.Assembly(name="pair")
    a.add(part, name="low", color=cq.Color("red"))
    a.add(part, name="high", loc=cq.Location(cq.Vector(0, 0, 100)), color=cq.Color("green"))
    return trimray.load(a)
