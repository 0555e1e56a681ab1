"""Shared by the tests of comparisons: reading without a child process, and short comparisons."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import trimray
from trimray.fidelity import Comparison, compare, running
from trimray.fidelity.running import Running
from trimray.importer import BrepModel


@pytest.fixture
def load_here(read_here: Callable[..., BrepModel]) -> Callable[[Path], trimray.Model]:
    """Reads a file in this process, without the second that a child takes to start."""
    from trimray.hierarchy import Hierarchy
    from trimray.loading import _store

    def load(path: Path) -> trimray.Model:
        return trimray.Model(Hierarchy(_store(read_here(path))), seconds={}, source=path.name)

    return load


def quick(a: Any, b: Any, **options: Any) -> Comparison:
    """A comparison with two small pictures."""
    words = {"points": 1500, "size": (96, 96), "images": False, "views": ("iso", "bottom")} | options
    return compare(a, b, **words)


def sections(comparison: Comparison) -> set[str]:
    """Those with differences."""
    return {finding.section for finding in comparison.differences()}


def named(comparison: Comparison, name: str) -> list[Any]:
    """The differences of one name."""
    return [finding for finding in comparison.differences() if finding.name == name]


@pytest.fixture
def test_folder(tmp_path: Path) -> Iterator[Running]:
    """Stands for a test of somebody else, in a file of tmp_path/tests."""
    folder = tmp_path / "tests"
    folder.mkdir()
    here = Running("tests/test_part.py::test_x", folder, tmp_path, tmp_path / running.FAILURES)
    before = running.enter(here)
    yield here
    running.enter(before)
