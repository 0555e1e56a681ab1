"""Each bad input is one error of the tree, with one line that names the file."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import trimray


def expect(path: Path, *words: str, error: type[trimray.Error] = trimray.InputError) -> None:
    for use_cache in (True, False):
        with pytest.raises(error) as caught:
            trimray.load(path, cache=use_cache)
        text = str(caught.value)
        assert "\n" not in text and path.name in text
        assert any(word in text.lower() for word in words), text


def test_missing(tmp_path: Path) -> None:
    expect(tmp_path / "nope.step", "no such file")


def test_directory(tmp_path: Path) -> None:
    expect(tmp_path, "directory")


def test_empty(tmp_path: Path) -> None:
    path = tmp_path / "a.step"
    path.touch()
    expect(path, "empty")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_permission_denied(tmp_path: Path) -> None:
    path = tmp_path / "a.step"
    path.write_text("x")
    path.chmod(0)
    expect(path, "permission denied")


def test_noise(tmp_path: Path) -> None:
    path = tmp_path / "a.step"
    path.write_bytes(bytes((i * 7919 + 13) % 256 for i in range(20000)))
    expect(path, "not a", "unknown", "neither", "cannot")


def test_truncated(box_file: Path, tmp_path: Path) -> None:
    path = tmp_path / "cut.step"
    path.write_bytes(box_file.read_bytes()[:2000])
    with pytest.raises(trimray.InputError) as caught:
        trimray.load(path)
    assert "\n" not in str(caught.value)


def test_no_faces(tmp_path: Path) -> None:
    path = tmp_path / "none.step"
    path.write_text(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    expect(path, "no face", "no shape", "empty", error=trimray.EmptyError)


def test_what_is_no_model_at_all() -> None:
    with pytest.raises(trimray.UsageError):
        trimray.load(42)


def test_wrong_options(box_file: Path) -> None:
    for wrong in ({"heal": "maybe"}, {"precision": -1.0}, {"time_limit": 0.0}, {"memory_limit": -5}):
        with pytest.raises(trimray.UsageError):
            trimray.load(box_file, **wrong)  # type: ignore[arg-type]


def test_time_limit(box_file: Path) -> None:
    with pytest.raises(trimray.TimeLimitError):
        trimray.load(box_file, cache=False, time_limit=0.01)


def test_memory_limit(box_file: Path) -> None:
    with pytest.raises(trimray.MemoryLimitError):
        trimray.load(box_file, cache=False, memory_limit=20_000_000)
