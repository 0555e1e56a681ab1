"""The cache: the same model again, without OpenCascade; never a wrong one, never an error."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import trimray
from trimray import cache


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "trimray"


def entries(folder: Path) -> list[Path]:
    return sorted(p for p in folder.rglob("*") if p.is_file())


def test_second_load_is_the_same_model(box_file: Path, folder: Path) -> None:
    first = trimray.load(box_file)
    assert not first.report.cached
    assert len(entries(folder)) == 1 and cache.size()[0] == 1
    second = trimray.load(box_file)
    assert second.report.cached and second.report.complete
    assert "cache" in second.report.seconds
    assert np.array_equal(first.bounds, second.bounds)
    assert list(first.faces) == list(second.faces)
    assert (first.unit, len(first.instances)) == (second.unit, len(second.instances))
    a, b = (m.render((32, 32), aovs=trimray.AOVS) for m in (first, second))
    for name in trimray.AOVS:
        assert a[name].tobytes() == b[name].tobytes()


def test_second_load_imports_no_opencascade(box_file: Path, folder: Path) -> None:
    trimray.load(box_file)
    code = (
        "import sys, trimray; m = trimray.load(sys.argv[1]); m.render((8, 8)).save(sys.argv[2]);"
        "assert m.report.cached;"
        "print([x for x in sys.modules if x.split('.')[0] in ('OCP', 'cadquery', 'rich')])"
    )
    out = folder.parent / "a.png"
    done = subprocess.run(
        [sys.executable, "-c", code, str(box_file), str(out)], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]" and out.stat().st_size > 100


def test_options_and_content_have_entries_of_their_own(box_file: Path, folder: Path, tmp_path: Path) -> None:
    trimray.load(box_file)
    trimray.load(box_file, heal="off")
    trimray.load(box_file, precision=0.01)
    other = tmp_path / "other.step"
    other.write_bytes(box_file.read_bytes() + b"\n")
    trimray.load(other)
    assert len(entries(folder)) == 4
    same = tmp_path / "same.step"
    same.write_bytes(box_file.read_bytes())
    assert trimray.load(same).report.cached
    # Limits change no result.
    assert trimray.load(box_file, time_limit=100).report.cached


def test_cache_off_writes_and_reads_nothing(box_file: Path, folder: Path) -> None:
    trimray.load(box_file, cache=False)
    assert not folder.exists()
    trimray.load(box_file)
    assert not trimray.load(box_file, cache=False).report.cached


@pytest.mark.parametrize("where", [0, 5, 20, 40, 300, -1, -200])
@pytest.mark.parametrize("how", ["flip", "cut"])
def test_a_damaged_entry_is_made_anew(box_file: Path, folder: Path, where: int, how: str) -> None:
    trimray.load(box_file)
    (entry,) = entries(folder)
    good = entry.read_bytes()
    bad = bytearray(good)
    if how == "flip":
        bad[where] ^= 0x55
    else:
        del bad[where:]
    entry.write_bytes(bad)
    again = trimray.load(box_file)
    assert not again.report.cached
    assert np.array_equal(again.bounds, [(0, 0, 0), (10, 20, 30)])
    assert trimray.load(box_file).report.cached


def test_a_cache_that_cannot_be_written_costs_nothing_but_time(
    box_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    assert len(trimray.load(box_file).faces) == 6
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/full")
    assert len(trimray.load(box_file).faces) == 6


def test_a_relative_cache_home_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", "/somewhere")
    assert str(cache.folder()) == "/somewhere/.cache/trimray"


def test_shapes_are_not_cached(folder: Path) -> None:
    cq = pytest.importorskip("cadquery")
    trimray.load(cq.Workplane().box(1, 2, 3))
    assert not folder.exists() or not entries(folder)


def test_files_that_refer_to_others_are_not_cached(box_file: Path, folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "outer.step"
    text = box_file.read_text()
    reference = "#99001=DOCUMENT_FILE('inner.step','',$,#99002,'',$);\n#99002=DOCUMENT_TYPE('');\n"
    path.write_text(text.replace("ENDSEC;\nEND-ISO", reference + "ENDSEC;\nEND-ISO"))
    assert "DOCUMENT_FILE" in path.read_text()
    trimray.load(path)
    assert not folder.exists() or not entries(folder)


def test_no_temporary_files_stay(box_file: Path, folder: Path) -> None:
    trimray.load(box_file)
    assert all(len(p.name) == 64 for p in entries(folder))
    assert oct(os.stat(folder).st_mode & 0o077) == "0o0"
