"""Shared fixtures: where the real models are, surroundings that no test shares with the user, files read in
this process, pages in a browser."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from tests.pages import Reader
    from trimray.importer import BrepModel

ROOT = Path(__file__).resolve().parent.parent
# What the user, or the system that runs the tests, has set for programs such as ours and Python's tools.
_FOREIGN = (
    *("TRIMRAY_", "NO_COLOR", "FORCE_COLOR", "PY_COLORS", "COLUMNS", "LINES", "TERM", "SOURCE_DATE_EPOCH"),
    *("PYTEST_ADDOPTS", "PYTHONWARNINGS", "DASK_", "GITHUB_", "GIT_", "LANGUAGE"),
    *("SLURM_ARRAY_", "AWS_BATCH_JOB_ARRAY_", "JOB_COMPLETION_INDEX", "PBS_ARRAY_INDEX"),
)
_KEPT = ("TRIMRAY_MODELS",)


def pytest_configure() -> None:
    # A shell that runs the tests in its background hands down an ignored SIGINT, and we to what we start.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def models_dir() -> Path:
    """The folder of real models (TRIMRAY_MODELS, default ../shared/models); skips when absent."""
    folder = Path(os.environ.get("TRIMRAY_MODELS", ROOT.parent / "shared" / "models"))
    if not folder.is_dir():
        pytest.skip(f"no real models: {folder} is not a folder (set TRIMRAY_MODELS)")
    return folder


@pytest.fixture(scope="session")
def samples_dir() -> Path:
    return ROOT / "samples"


@pytest.fixture(scope="session", autouse=True)
def _own_surroundings(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """For fixtures of any scope, too."""
    with pytest.MonkeyPatch.context() as patch:
        for name in os.environ:
            if name.startswith(_FOREIGN) and name not in _KEPT:
                patch.delenv(name)
        patch.setenv("LC_ALL", "C.UTF-8")
        for name in ("GIT_CONFIG_GLOBAL", "GIT_CONFIG_SYSTEM"):
            patch.setenv(name, os.devnull)
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp() / "cache"))
        patch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.getbasetemp() / "config"))
        yield


@pytest.fixture(autouse=True)
def _free_documents() -> Iterator[None]:
    """Readers are kept alive on purpose (occt.transfer); not over a whole test run."""
    yield
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


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    from tests.pages import CHROMIUM

    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not os.access(CHROMIUM, os.X_OK):
        pytest.skip(f"no {CHROMIUM}")
    with playwright.sync_playwright() as started:
        root = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = started.chromium.launch(executable_path=CHROMIUM, args=[*root, "--disable-gpu"])
        yield browser
        browser.close()


@pytest.fixture
def open_page(browser: Any) -> Iterator[Any]:
    """open_page(path or URL, hash, **options of the context): a Reader of the page, on which nothing may go
    wrong, nor be asked of the outside."""
    from tests.pages import Reader

    readers: list[Reader] = []
    contexts = []

    def call(path: str, hash: str = "", reader: type[Reader] = Reader, **options: Any) -> Reader:
        context = browser.new_context(**{"viewport": {"width": 1200, "height": 800}, **options})
        contexts.append(context)
        readers.append(
            reader(context.new_page(), (path if path.startswith("http:") else Path(path).as_uri()) + hash)
        )
        return readers[-1]

    yield call
    for context in contexts:
        context.close()
    for reader in readers:
        assert reader.errors == []
        assert [url for url in reader.requests if not url.startswith(("file://", "data:"))] == []
