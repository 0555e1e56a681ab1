"""Shared by the exporter's tests: a file read in this process, and its store."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from trimray.importer import BrepModel


@pytest.fixture(autouse=True)
def _free_documents() -> Iterator[None]:
    yield
    from trimray.importer import occt

    occt._kept.clear()


@pytest.fixture
def read_here(tmp_path: Path) -> Callable[[Path | str], BrepModel]:
    """Reads a file without the second that a child takes to start."""
    from trimray.importer.read_file import read_file

    return lambda path: read_file(str(path), name=str(path), folder=str(tmp_path))
