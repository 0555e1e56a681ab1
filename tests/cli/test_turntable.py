"""trimray turntable: what it writes, and what it leaves when it is stopped."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from .conftest import Run, interrupted


def test_numbered_pictures(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("turntable", box_file, "-o", tmp_path / "%02d.png", "--size", "24", "--frames", "3")
    assert (result.code, result.out, result.err) == (0, b"", "")
    assert sorted(os.listdir(tmp_path)) == ["01.png", "02.png", "03.png"]
    assert len({(tmp_path / name).read_bytes() for name in os.listdir(tmp_path)}) == 3


@pytest.mark.parametrize("format", ["webp", "gif"])
def test_moving_pictures(run: Run, box_file: Path, tmp_path: Path, format: str) -> None:
    arguments = ("--size", "24", "--frames", "4", "--fps", "8", "--view", "0,20")
    assert run("turntable", box_file, "-o", tmp_path / f"a.{format}", *arguments).code == 0
    data = (tmp_path / f"a.{format}").read_bytes()
    assert data[:4] in (b"RIFF", b"GIF8")
    to_stdout = run("turntable", box_file, "-o", "-", "--format", format, *arguments)
    assert to_stdout.code == 0 and to_stdout.out == data
    assert run("turntable", box_file, "-o", f"{tmp_path}/", "--format", format, *arguments).code == 0
    assert (tmp_path / f"box.{format}").read_bytes() == data


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("-o", "a.png"), "numbered pictures, such as %04d.png"),
        (("-o", "a%d-%d.png"), "one number only"),
        (("-o", "a.webp", "--frames", "0"), "--frames"),
        (("-o", "a.webp", "--fps", "0"), "--fps"),
        (("-o", "a.webp", "--fps", "1000"), "more than 100"),
        (("-o", "a.gif", "--background", "transparent"), "soft transparency"),
        (("-o", "a.webp", "--aov", "color,depth"), "one plane only"),
        (("-o", "%d.png", "--aov", "color,depth"), "write exr"),
    ],
)
def test_wrong_usage(run: Run, box_file: Path, arguments: tuple[str, ...], match: str) -> None:
    result = run("turntable", box_file, *arguments)
    assert result.code == 2 and match in result.err


def test_planes_of_every_frame(run: Run, box_file: Path, tmp_path: Path) -> None:
    common = ("--size", "16", "--frames", "2")
    assert run("turntable", box_file, "-o", tmp_path / "%d.exr", "--aov", "depth,face", *common).code == 0
    assert run("turntable", box_file, "-o", tmp_path / "face.gif", "--aov", "face", *common).code == 0
    assert sorted(os.listdir(tmp_path)) == ["1.exr", "2.exr", "face.gif"]


@pytest.mark.parametrize("name", ["spin.webp", "%03d.png"])
def test_ctrl_c_leaves_nothing_half_written(box_file: Path, tmp_path: Path, name: str) -> None:
    words = ("turntable", box_file, "-o", tmp_path / name, "--size", "500", "--frames", "10000")
    code, err = interrupted(*words, "--samples", "16", stage="turn")
    assert code == 130 and err == "trimray: interrupted"
    left = sorted(os.listdir(tmp_path))
    assert left == [f"{k:03d}.png" for k in range(1, len(left) + 1)]
    assert all((tmp_path / picture).read_bytes().endswith(b"IEND\xaeB`\x82") for picture in left)
