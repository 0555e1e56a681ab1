"""trimray thumbnailer: what it prints, where it writes, how it ends."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from trimray.cli.__main__ import main
from trimray.desktop import install


@dataclass
class Result:
    code: int
    out: str
    err: str


Run = Callable[..., Result]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: object) -> Result:
        capfd.readouterr()
        code = main(["thumbnailer", *(str(a) for a in arguments)])
        captured = capfd.readouterr()
        return Result(code, captured.out, captured.err)

    return call


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder of data, and the program beside this Python."""
    program = tmp_path / "bin" / install.PROGRAM
    program.parent.mkdir()
    program.touch(mode=0o755)
    monkeypatch.setattr(install.sys, "executable", str(program.with_name("python")))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_DATA_DIRS", "/nowhere")
    return tmp_path / "data"


def test_install_and_uninstall(run: Run, data: Path) -> None:
    dry = run("install", "--dry-run")
    assert dry.code == 0 and not data.exists()
    assert dry.out.splitlines()[:2] == [
        f"write {data}/mime/packages/trimray.xml",
        f"write {data}/thumbnailers/trimray.thumbnailer",
    ]
    tool = shutil.which("update-mime-database") is not None
    done = run("install")
    assert done.code == (0 if tool else 1) and done.out == ""
    assert "lies outside of /usr" in done.err and done.err.count("\n") == (1 if tool else 2)
    entry = (data / "thumbnailers" / "trimray.thumbnailer").read_text()
    assert f"Exec={data.parent}/bin/trimray-thumbnailer -s %s %i %o\n" in entry
    assert run("uninstall").code == (0 if tool else 1)
    assert list(data.iterdir()) == []


def test_what_was_changed_is_left(run: Run, data: Path) -> None:
    run("install")
    entry = data / "thumbnailers" / "trimray.thumbnailer"
    entry.write_text(entry.read_text() + "# mine\n")
    done = run("install")
    assert done.code == 4 and "not as we wrote it" in done.err and done.err.count("\n") == 1
    assert run("uninstall").code == 1 and entry.exists()


def test_not_permitted(run: Run, data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_DIRS", "/proc")
    done = run("install", "--system")
    assert done.code == 4 and done.err.count("\n") == 1 and "/proc/" in done.err
    monkeypatch.delenv("XDG_DATA_HOME")
    monkeypatch.delenv("HOME", raising=False)
    assert run("install", "--user").code == 4


def test_without_the_program(run: Run, data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(install.sys, "executable", "/nowhere/python")
    monkeypatch.setenv("PATH", "/nowhere")
    done = run("install")
    assert done.code == 4 and "nothing installed" in done.err and not data.exists()


def test_the_cache(run: Run, tmp_path: Path, samples_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "library").mkdir()
    (tmp_path / "library" / "cut.stl").write_bytes(b"solid")
    shutil.copy(samples_dir / "stand.stl", tmp_path / "library")
    done = run("cache", tmp_path / "library", "--size", "normal", "-j", "1")
    lines = done.err.splitlines()
    assert done.code == 1 and done.out == "" and len(lines) == 2
    assert "cut.stl: failed" in lines[0] and "2 files: 1 complete, 1 failed" in lines[1]
    assert len(os.listdir(tmp_path / "cache" / "thumbnails" / "normal")) == 1
    done = run("cache", tmp_path / "library", "--size", "normal")
    assert done.code == 1 and "1 up to date, 1 failed before" in done.err
    assert run("cache", tmp_path / "cache").code == 6


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "missing input"),
        (["instal"], "did you mean"),
        (["cache"], "missing input"),
        (["install", "more"], "takes no 'more'"),
        (["install", "--size", "large"], "takes no --size"),
        (["cache", "x", "--system"], "takes no --system"),
        (["uninstall", "-j", "2"], "takes no --jobs"),
        (["cache", "x", "--size", "256"], "--size"),
    ],
)
def test_wrong_usage(run: Run, data: Path, arguments: list[str], text: str) -> None:
    done = run(*arguments)
    assert done.code == 2 and text in done.err and done.out == ""
    assert not data.exists()
