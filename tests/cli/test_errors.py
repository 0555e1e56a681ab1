"""Every failure: one line on stderr, the right exit code, nothing half-written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from .conftest import Run, interrupted, one_line, process


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("render",), "missing input"),
        (("render", "a.step"), "missing output"),
        (("rendr", "a.step"), "did you mean 'render'"),
        (("render", "a.step", "-o", "a.png", "--sise", "3"), "--size"),
        (("render", "a.step", "-o", "a.png", "--view", "tpo"), "did you mean 'top'"),
        (("render", "a.step", "-o", "a.png", "--size", "0,5"), "--size"),
        (("render", "a.step", "-o", "a.png", "--samples", "many"), "--samples"),
        (("render", "a.step", "-o", "a.png", "--background", "blu"), "did you mean 'blue'"),
        (("render", "a.step", "-o", "a.png", "--aov", "dept"), "did you mean 'depth'"),
        (("render", "a.step", "-o", "a.png", "--aov", "color,depth"), "write exr"),
        (("render", "a.step", "-o", "a.png", "--up", "w"), "--up"),
        (("render", "a.step", "-o", "a.png", "--mode", "fast"), "--mode"),
        (("render", "a.step", "-o", "a.png", "--heal", "no"), "--heal"),
        (("render", "a.step", "-o", "a.png", "--precision", "-1"), "--precision"),
        (("render", "a.step", "-o", "a.png", "--time-limit", "soon"), "--time-limit"),
        (("render", "a.step", "-o", "a.png", "--memory-limit", "lots"), "--memory-limit"),
        (("render", "a.step", "-o", "a.png", "-j", "all"), "--jobs"),
        (("render", "a.step", "-o", "a.png", "--progress", "dots"), "--progress"),
        (("render", "a.step", "-o", "a.jpg", "--background", "transparent"), "transparency"),
        (("render", "a.step", "-o", "a.avif"), "OpenImageIO wheel lacks it"),
        (("render", "a.step", "-o", "picture"), "no extension"),
        (("render", "a.step", "-o", "a.pgn"), "did you mean 'png'"),
        (("mesh", "a.step", "-o", "a.step"), "unknown mesh format"),
        (("mesh", "a.step", "-o", "a.stl", "--deviation", "0"), "--deviation"),
        (("mesh", "a.step", "-o", "a.stl", "--deviation", "1 inch"), "not a positive length"),
        (("mesh", "a.step", "-o", "a.stl", "--angle", "-1"), "--angle"),
        (("render", "a.step", "x/a.step", "-o", "{name}.png"), "both be written"),
        (("render", "a.png", "-o", "a.png"), "overwrite the input"),
        (("render", "-", "-", "-o", "{name}.png"), "once only"),
        (("render", "a.step", "-o", "-", "--report", "-"), "both go to stdout"),
        (("info",), "missing input"),
        (("completion", "tcsh"), "tcsh"),
    ],
)
def test_wrong_usage(
    run: Run, arguments: tuple[str, ...], match: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.code == 2
    assert one_line(result.err) and match in result.err, result.err
    assert result.out == b"" and os.listdir(tmp_path) == []


@pytest.mark.parametrize("kind", ["missing", "directory", "empty", "noise", "truncated", "no faces"])
def test_bad_input(run: Run, box_file: Path, tmp_path: Path, kind: str) -> None:
    path = tmp_path / "bad.step"
    if kind == "directory":
        path.mkdir()
    elif kind == "empty":
        path.touch()
    elif kind == "noise":
        path.write_bytes(bytes((i * 7919 + 13) % 256 for i in range(20000)))
    elif kind == "truncated":
        path.write_bytes(box_file.read_bytes()[:1500])
    elif kind == "no faces":
        head, _, _ = box_file.read_text().partition("DATA;")
        path.write_text(head + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    for command in (("render", path, "-o", tmp_path / "a.png"), ("info", path)):
        result = run(*command)
        assert result.code == 3, result.err
        assert one_line(result.err) and "bad.step" in result.err
        assert result.out == b"" and not (tmp_path / "a.png").exists()


def test_limits(run: Run, box_file: Path, tmp_path: Path) -> None:
    for limit in (("--time-limit", "0.02"), ("--memory-limit", "20M")):
        result = run("render", box_file, "-o", tmp_path / "a.png", "--no-cache", *limit)
        assert result.code == 5 and one_line(result.err), result.err
    assert os.listdir(tmp_path) == []


def test_unwritable_output(run: Run, box_file: Path, tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    for target in (tmp_path / "no" / "a.png", tmp_path / "folder.png" / ".." / "folder.png" / "x" / "a.png"):
        result = run("render", box_file, "-o", target, "--size", "9")
        assert result.code == 4 and one_line(result.err) and "not written" in result.err
    result = run("render", box_file, "-o", "/dev/full", "--format", "png", "--size", "9")
    assert result.code == 4 and one_line(result.err) and "No space left" in result.err


def test_full_stdout(box_file: Path) -> None:
    for command in (("render", box_file, "-o", "-", "--size", "9"), ("info", box_file), ("--version",)):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(
                [sys.executable, "-m", "trimray.cli", *(str(c) for c in command)],
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
        assert done.returncode == 4, command
        assert one_line(done.stderr) and "No space left" in done.stderr


def test_internal_errors_are_70_and_one_line(
    run: Run, box_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import trimray.cli.render

    def broken(*_: object) -> None:
        raise RuntimeError("a bug\nwith two lines")

    monkeypatch.setattr(trimray.cli.render, "_draw", broken)
    result = run("render", box_file, "-o", tmp_path / "a.png")
    assert result.code == 70 and one_line(result.err) and "a bug" in result.err


def test_ctrl_c_ends_at_once_and_leaves_nothing(box_file: Path, tmp_path: Path) -> None:
    """Amid a picture that would take minutes."""
    words = ("render", box_file, "-o", tmp_path / "a.png", "--size", "4000", "--samples", "1024")
    code, err = interrupted(*words, stage="trace")
    assert code == 130 and err == "trimray: interrupted"
    assert os.listdir(tmp_path) == []


def test_colour_follows_no_color_and_force_color(tmp_path: Path) -> None:
    missing = tmp_path / "a.step"
    assert "\x1b[" not in process("info", missing).err
    assert "\x1b[" in process("info", missing, FORCE_COLOR="1").err
    assert "\x1b[" not in process("info", missing, FORCE_COLOR="1", NO_COLOR="1").err
