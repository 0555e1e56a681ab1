"""Shared by the importer's tests: files made on the spot, and the folder of real models."""

import csv
import os
from collections.abc import Callable
from pathlib import Path

import pytest


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
