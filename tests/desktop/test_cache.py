"""The freedesktop cache: names, keys, permissions, what is skipped and what is not."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest

from trimray import OutputError, __version__
from trimray.batch import Item, Listener, Outcome, Settings
from trimray.desktop import cache, entries
from trimray.desktop.cache import draw_thumbnail, fill_cache
from trimray.desktop.entries import Original

from .conftest import opened


class Heard(Listener):
    def __init__(self) -> None:
        self.told: list[tuple[str, str, str]] = []

    def skipped(self, outcome: Outcome) -> None:
        self.told.append(("skipped", os.path.basename(outcome.path), outcome.reason))

    def drawn(self, outcome: Outcome) -> None:
        self.told.append((outcome.status, os.path.basename(outcome.path), outcome.reason))


@pytest.fixture
def thumbnails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the cache; not there yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg" / "cache"))
    return tmp_path / "xdg" / "cache" / "thumbnails"


@pytest.fixture
def library(tmp_path: Path, samples_dir: Path) -> Path:
    """A good file with a bad name, and one that is cut off."""
    folder = tmp_path / "library"
    folder.mkdir()
    shutil.copy(samples_dir / "stand.stl", folder / "a b'\n%\udcff.stl")
    (folder / "cut.stl").write_bytes((samples_dir / "stand.stl").read_bytes()[:500])
    return folder


Draw = Callable[[Item, Settings], Outcome]


def here(items: Iterable[Item], settings: Settings, workers: int, *, draw: Draw) -> Iterator[Outcome]:
    """The pool's work, in this process."""
    for item in items:
        yield draw(item, settings)


def failing(exit_code: int) -> Callable[..., Iterator[Outcome]]:
    """A pool in which every file fails so."""

    def draw_all(
        items: Iterable[Item], settings: Settings, workers: int, *, draw: object
    ) -> Iterator[Outcome]:
        for item in items:
            yield Outcome(item.path, item.target, "failed", exit_code, "it\ncrashed \u2192")

    return draw_all


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_the_cache_in_full(library: Path, thumbnails: Path) -> None:
    """With real workers: a picture, a failure, and neither again."""
    heard = Heard()
    filled = fill_cache([str(library)], "normal", workers=2, listener=heard)
    assert (filled.total, dict(filled.statuses)) == (2, {"complete": 1, "failed": 1})
    assert filled.exit_code == 1
    good, bad = (Original.of(str(library / name)) for name in ("a b'\n%\udcff.stl", "cut.stl"))
    failed = f"fail/trimray-{__version__}/{bad.name}"
    assert files(thumbnails) == sorted([f"normal/{good.name}", failed])

    image = opened(thumbnails / "normal" / good.name)
    assert image.size == (128, 128) and image.mode == "RGBA"
    assert 0.1 < (np.asarray(image)[..., 3] == 255).mean() < 0.9
    for path, original in ((thumbnails / "normal" / good.name, good), (thumbnails / failed, bad)):
        keys = opened(path).info
        assert keys["Thumb::URI"] == original.uri and keys["Thumb::URI"].startswith("file:///")
        assert keys["Thumb::MTime"] == str(original.mtime)
        assert keys["Thumb::Size"] == str(original.size)
        assert keys["Software"] == f"trimray {__version__}"
    for path in (thumbnails, *thumbnails.rglob("*")):
        mode = stat.S_IMODE(path.stat().st_mode)
        assert mode == (0o700 if path.is_dir() else 0o600), path

    heard.told.clear()
    again = fill_cache([str(library)], "normal", workers=2, listener=heard)
    assert (again.current, again.skipped, dict(again.statuses)) == (1, 1, {})
    assert again.exit_code == filled.exit_code
    assert [kind for kind, _, _ in heard.told] == ["skipped", "skipped"]
    assert any(name == "cut.stl" and reason for _, name, reason in heard.told)


@pytest.mark.skipif(shutil.which("gio") is None, reason="no gio (libglib2.0-bin)")
def test_the_desktop_finds_it(library: Path, thumbnails: Path) -> None:
    good = library / "a b'\n%\udcff.stl"
    fill_cache([str(library)], draw_all=here)
    command = ["gio", "info", "-a", "thumbnail::*", os.fsencode(good)]
    told = subprocess.run(command, capture_output=True, check=True).stdout.decode(errors="replace")
    assert f"thumbnail::path: {thumbnails}/large/{Original.of(str(good)).name}" in told
    assert "thumbnail::is-valid: TRUE" in told


def test_a_change_of_the_file_makes_it_new(library: Path, thumbnails: Path) -> None:
    good = library / "a b'\n%\udcff.stl"
    os.utime(good, ns=(10**18, 10**18 + 999_999_999))
    fill_cache([str(good)], draw_all=here)
    picture = thumbnails / "large" / Original.of(str(good)).name
    assert opened(picture).info["Thumb::MTime"] == "1000000000"
    os.utime(good, ns=(10**18, 10**18 + 10**9))
    assert fill_cache([str(good)], draw_all=here).current == 0
    assert opened(picture).info["Thumb::MTime"] == "1000000001"
    assert fill_cache([str(good)], draw_all=here).current == 1


def test_a_failure_is_tried_again_when_file_or_version_changes(
    library: Path, thumbnails: Path, samples_dir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = library / "cut.stl"
    assert fill_cache([str(bad)], draw_all=here).exit_code == 3
    assert fill_cache([str(bad)], draw_all=here).skipped == 1
    monkeypatch.setattr(entries, "__version__", "99")
    assert fill_cache([str(bad)], draw_all=here).skipped == 0
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(thumbnails.parent))
    shutil.copy(samples_dir / "stand.stl", bad)
    filled = fill_cache([str(bad)], draw_all=here)
    assert (filled.skipped, filled.statuses["complete"]) == (0, 1)
    assert not (thumbnails / "fail" / f"trimray-{__version__}" / Original.of(str(bad)).name).exists()


@pytest.mark.parametrize(("exit_code", "kept"), [(3, True), (5, True), (70, True), (4, False)])
def test_what_a_worker_died_of_is_remembered_but_no_full_disk(
    library: Path, thumbnails: Path, exit_code: int, kept: bool
) -> None:
    filled = fill_cache([str(library)], draw_all=failing(exit_code))
    assert filled.exit_code == exit_code
    assert len(files(thumbnails)) == (2 if kept else 0)
    heard = Heard()
    again = fill_cache([str(library)], draw_all=failing(exit_code), listener=heard)
    assert again.exit_code == exit_code and again.skipped == (2 if kept else 0)
    if kept:
        assert {reason for _, _, reason in heard.told} == {"it crashed \\u2192"}


def test_a_blank_picture_is_a_failure(thumbnails: Path, tmp_path: Path, samples_dir: Path) -> None:
    """A needle, seen end on it would be; here, a picture of one pixel in which nothing can be seen."""
    item = Item(str(samples_dir / "stand.stl"), str(tmp_path / "out.png"))
    outcome = draw_thumbnail(item, Settings(size=(1, 1), background="transparent"))
    assert (outcome.status, outcome.exit_code) == ("failed", 3) and "blank" in outcome.reason
    assert not (tmp_path / "out.png").exists()


def test_the_thumbnail_of_another_program_is_left_alone(library: Path, thumbnails: Path) -> None:
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    good = library / "a b'\n%\udcff.stl"
    original = Original.of(str(good))
    info = PngInfo()
    info.add_text("Thumb::URI", original.uri)
    info.add_text("Thumb::MTime", str(original.mtime))
    target = thumbnails / "large" / original.name
    target.parent.mkdir(parents=True)
    Image.new("RGB", (3, 3)).save(target, pnginfo=info)
    before = target.read_bytes()
    assert fill_cache([str(good)], draw_all=here).current == 1
    assert target.read_bytes() == before
    target.write_bytes(before[:-5])  # a half of one is none
    assert fill_cache([str(good)], draw_all=here).current == 0
    assert opened(target).size == (256, 256)


@pytest.mark.parametrize(
    "content", [b"", b"\x89PNG\r\n\x1a\n", b"\x89PNG\r\n\x1a\n\xff\xff\xff\xfftEXtIEND\xaeB`\x82", b"GIF89a"]
)
def test_what_is_no_entry(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.png"
    path.write_bytes(content)
    assert not (entries.text_keys(str(path)) or {})
    assert entries.text_keys(str(tmp_path)) is None and entries.text_keys(str(tmp_path / "none")) is None


def test_what_cannot_be_read_is_no_failure_of_the_file(library: Path, thumbnails: Path) -> None:
    filled = fill_cache([str(library / "none.step")], draw_all=here)
    assert filled.exit_code == 3 and files(thumbnails) == []
    os.mkfifo(library / "pipe.step")
    filled = fill_cache([str(library / "pipe.step")], draw_all=here)
    assert filled.exit_code == 3 and files(thumbnails) == []
    (library / "loop.step").symlink_to("loop.step")
    filled = fill_cache([str(library / "loop.step")], draw_all=here)
    assert filled.exit_code == 3 and files(thumbnails) == []


def test_nothing_found(tmp_path: Path, thumbnails: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert fill_cache([str(tmp_path / "empty")], draw_all=here).exit_code == 6


def test_a_cache_that_cannot_be_written(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(OutputError):
        fill_cache([str(library)], draw_all=here)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.delenv("HOME", raising=False)
    with pytest.raises(OutputError, match="no cache"):
        fill_cache([str(library)], draw_all=here)


def test_an_interruption_ends_the_workers(library: Path, thumbnails: Path) -> None:
    ended = []

    def draw_all(
        items: Iterable[Item], settings: Settings, workers: int, *, draw: object
    ) -> Iterator[Outcome]:
        try:
            for item in items:
                yield Outcome(item.path, item.target, "complete")
        finally:
            ended.append(True)

    class Interrupted(Listener):
        def drawn(self, outcome: Outcome) -> None:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill_cache([str(library)], draw_all=draw_all, listener=Interrupted())
    assert ended == [True]


def test_the_sizes_of_the_standard() -> None:
    assert cache.SIZES == {"normal": 128, "large": 256, "x-large": 512, "xx-large": 1024}
