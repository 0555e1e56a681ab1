"""A headless browser with a gallery to open in it; a small library with a stand-in for the pool."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from trimray.batch import Summary, run
from trimray.batch.gallery import write_gallery
from trimray.batch.record import Settings

from .gallery_reader import CHROMIUM, Reader, library
from .run_stand_in import Drawer


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright")
    if not os.access(CHROMIUM, os.X_OK):
        pytest.skip(f"no {CHROMIUM}")
    with playwright.sync_playwright() as started:
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = started.chromium.launch(executable_path=CHROMIUM, args=[*root, "--disable-gpu"])
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser: Any) -> Iterator[Any]:
    """open_page(path, hash="", **options of the context): a Reader, on whose page nothing may go wrong."""
    readers: list[Reader] = []
    contexts = []

    def call(path: str, hash: str = "", **options: Any) -> Reader:
        context = browser.new_context(**{"viewport": {"width": 1200, "height": 800}, **options})
        contexts.append(context)
        readers.append(
            Reader(context.new_page(), (path if path.startswith("http:") else Path(path).as_uri()) + hash)
        )
        return readers[-1]

    yield call
    for context in contexts:
        context.close()
    for reader in readers:
        assert reader.errors == []
        assert [url for url in reader.requests if not url.startswith(("file://", "data:"))] == []


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
