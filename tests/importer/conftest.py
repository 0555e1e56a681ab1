"""Shared by the importer's tests: files made on the spot, and the folder of real models."""

import csv
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from trimray.importer import BrepModel


@pytest.fixture(autouse=True)
def _free_documents() -> Iterator[None]:
    """Readers are kept alive on purpose (occt.transfer); not over a whole test run."""
    yield
    import sys

    occt = sys.modules.get("trimray.importer.occt")
    if occt is not None:
        occt._kept.clear()


@pytest.fixture
def read_here(tmp_path: Path) -> Callable[..., BrepModel]:
    """Reads a file in this process: the child's code without the second it takes to start one."""
    from trimray.importer.read_file import read_file

    def read(path: Path | str, **options: Any) -> BrepModel:
        return read_file(str(path), name=str(path), folder=str(tmp_path), **options)

    return read


def models_folder() -> Path | None:
    """The folder of real models, None where there is none."""
    folder = os.environ.get("TRIMRAY_MODELS")
    return Path(folder) if folder and (Path(folder) / "MANIFEST.tsv").is_file() else None


def manifest() -> list[dict[str, str]]:
    folder = models_folder()
    if folder is None:
        return []
    with (folder / "MANIFEST.tsv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


@pytest.fixture
def real_model() -> Callable[[str], Path]:
    """Path of a real model by its name in the manifest; skips the test where the models are not at hand."""

    def find(name: str) -> Path:
        folder = models_folder()
        if folder is None:
            pytest.skip("TRIMRAY_MODELS does not name a folder with a MANIFEST.tsv")
        return folder / name

    return find
