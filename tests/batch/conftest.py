"""A gallery to open in a browser; a small library with a stand-in for the pool."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from trimray.batch import Summary, run
from trimray.batch.gallery import write_gallery
from trimray.batch.record import Settings

from .gallery_reader import GalleryReader, library
from .run_stand_in import Drawer


@pytest.fixture
def open_page(open_page: Callable[..., Any]) -> Callable[..., Any]:
    """As that of all tests, with a GalleryReader."""
    return partial(open_page, reader=GalleryReader)


@pytest.fixture(scope="module")
def gallery(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("gallery")
    outcomes = library(folder)
    sizes = {outcome.path: 1000 - i for i, outcome in enumerate(outcomes)}
    return write_gallery(folder, outcomes, title="Parts", settings=Settings(), sizes=sizes)


@pytest.fixture
def draw() -> Drawer:
    return Drawer()


@pytest.fixture(name="library")
def small_library(tmp_path: Path) -> Path:
    folder = tmp_path / "lib"
    for name, text in (
        ("a.step", "good a"),
        ("sub/b.step", "good b"),
        ("c.stl", "bad c"),
        ("d.step", "good d"),
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def go(library: Path, tmp_path: Path, draw: Drawer) -> Callable[..., Summary]:
    def call(paths: list[str] | None = None, **words: object) -> Summary:
        chosen = [str(library)] if paths is None else paths
        return run(chosen, str(tmp_path / "out"), draw=draw, **words)  # type: ignore[arg-type]

    return call
