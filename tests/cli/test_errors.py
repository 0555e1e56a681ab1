"""Every failure: one line on stderr, the right exit code, nothing half-written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from .conftest import Run, one_line, process


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
    command = [sys.executable, "-m", "trimray.cli", "render", str(box_file), "-o", str(tmp_path / "a.png")]
    child = subprocess.Popen(
        [*command, "--size", "2000", "--samples", "1024"],
        stderr=subprocess.PIPE,
        text=True,
        # A test run in the background of a shell hands down an ignored SIGINT.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        time.sleep(4.0)
        assert child.poll() is None
        child.send_signal(signal.SIGINT)
        start = time.monotonic()
        _, err = child.communicate(timeout=20)
        assert time.monotonic() - start < 5
    finally:
        child.kill()
    assert child.returncode == 130 and err.strip().splitlines()[-1] == "trimray: interrupted"
    assert os.listdir(tmp_path) == []


def test_colour_follows_no_color_and_force_color(tmp_path: Path) -> None:
    missing = tmp_path / "a.step"
    assert "\x1b[" not in process("info", missing).err
    assert "\x1b[" in process("info", missing, FORCE_COLOR="1").err
    assert "\x1b[" not in process("info", missing, FORCE_COLOR="1", NO_COLOR="1").err
