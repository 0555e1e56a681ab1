"""trimray render: every option, where pictures go, and what is said."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from .conftest import Run, process


def pixels(path: Path) -> np.ndarray:
    return oiio.ImageInput.open(str(path)).read_image("uint8")


def test_draws_a_file_and_says_nothing(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("render", box_file, "-o", tmp_path / "a.png")
    assert (result.code, result.out, result.err) == (0, b"", "")
    assert pixels(tmp_path / "a.png").shape == (512, 512, 3)
    assert os.listdir(tmp_path) == ["a.png"]


@pytest.mark.parametrize(
    "option",
    [
        ("--view", "top"),
        ("--view", "-30,20"),
        ("--up", "x"),
        ("--up", "y"),
        ("--projection", "perspective"),
        ("--samples", "1"),
        ("--background", "#204060"),
        ("--background", "white,black"),
        ("--background", "transparent"),
        ("--format", "png"),
        ("--orientation",),
        ("--heal", "off"),
        ("--precision", "0.001"),
        ("--time-limit", "100s"),
        ("--memory-limit", "4G"),
        ("-j", "1"),
        ("--jobs", "2"),
        ("--no-cache",),
        ("--progress", "none"),
        ("-q",),
        ("--aov", "color"),
    ],
)
def test_each_option_is_taken(run: Run, box_file: Path, tmp_path: Path, option: tuple[str, ...]) -> None:
    plain, other = tmp_path / "plain.png", tmp_path / "other.png"
    assert run("render", box_file, "-o", plain, "--size", "48,32").code == 0
    result = run("render", box_file, "-o", other, "--size", "48,32", *option)
    assert (result.code, result.err) == (0, "")
    changes = option[0] in ("--view", "--up", "--projection", "--samples", "--background")
    assert (plain.read_bytes() != other.read_bytes()) == changes


def test_reference_mode_draws_the_same(run: Run, box_file: Path, tmp_path: Path) -> None:
    for mode in ("standard", "reference"):
        assert (
            run("render", box_file, "-o", tmp_path / f"{mode}.png", "--size", "12", "--mode", mode).code == 0
        )
    difference = pixels(tmp_path / "standard.png").astype(int) - pixels(tmp_path / "reference.png")
    assert np.abs(difference).max() <= 1


@pytest.mark.parametrize("extension", ["png", "jpg", "webp", "tif", "exr"])
def test_bytes_are_the_same_for_1_and_n_threads(
    run: Run, ball_file: Path, tmp_path: Path, extension: str
) -> None:
    files = [tmp_path / f"{n}.{extension}" for n in (1, 2, 3)]
    for n, file in enumerate(files, 1):
        assert run("render", ball_file, "-o", file, "-j", n, "--size", "70,50").code == 0
    assert len({file.read_bytes() for file in files}) == 1


def test_exr_holds_the_planes_asked_for(run: Run, ball_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "a.exr"
    assert (
        run("render", ball_file, "-o", out, "--aov", "depth,face", "--aov", "normal", "--size", "20").code
        == 0
    )
    names = oiio.ImageInput.open(str(out)).spec().channelnames
    assert set(names) == {"depth.Z", "face.I", "normal.X", "normal.Y", "normal.Z"}


def test_several_inputs_to_a_folder_and_a_pattern(
    run: Run, box_file: Path, ball_file: Path, tmp_path: Path
) -> None:
    small = ("--size", "16")
    assert run("render", box_file, ball_file, "-o", tmp_path, *small).code == 0
    assert run("render", box_file, ball_file, "-o", tmp_path / "x_{name}.webp", *small).code == 0
    assert run("render", box_file, "-o", f"{tmp_path}/", "--format", "jpeg", *small).code == 0
    assert sorted(os.listdir(tmp_path)) == ["ball.png", "box.jpg", "box.png", "x_ball.webp", "x_box.webp"]


def test_one_bad_file_does_not_end_a_batch(run: Run, box_file: Path, tmp_path: Path) -> None:
    report = tmp_path / "report.json"
    missing = tmp_path / "missing.step"
    arguments = (
        "render",
        missing,
        box_file,
        "-o",
        tmp_path / "{name}.png",
        "--size",
        "16",
        "--report",
        report,
    )
    result = run(*arguments)
    assert result.code == 1
    assert result.err.count("\n") == 1 and "missing.step" in result.err
    assert (tmp_path / "box.png").exists() and not (tmp_path / "missing.png").exists()
    results = json.loads(report.read_text())["results"]
    assert [r["exit_code"] for r in results] == [3, 0]
    assert "missing.step" in results[0]["error"] and results[1]["error"] is None
    assert results[1]["report"]["faces"] == 6 and results[1]["report"]["complete"] is True


def test_when_all_fail_alike_their_code_is_the_code(run: Run, tmp_path: Path) -> None:
    result = run("render", tmp_path / "a.step", tmp_path / "b.step", "-o", tmp_path)
    assert result.code == 3 and result.err.count("\n") == 2


def test_stdin_and_stdout(box_file: Path, tmp_path: Path) -> None:
    result = process("render", "-", "-o", "-", "--size", "20", input=box_file.read_bytes())
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith(b"\x89PNG")
    assert process("render", box_file, "-o", tmp_path / "a.png", "--size", "20").code == 0
    assert (tmp_path / "a.png").read_bytes() == result.out
    exr = process("render", "-", "-o", "-", "--size", "9", "--format", "exr", input=box_file.read_bytes())
    assert exr.out[:4] == b"\x76\x2f\x31\x01"
    assert process("render", "-", "-o", "-", input=b"").code == 3


def test_report_to_stdout(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("render", box_file, "-o", tmp_path / "a.png", "--size", "9", "--report", "-")
    assert json.loads(result.out)["results"][0]["output"].endswith("a.png")


def test_dry_run_writes_nothing(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("render", box_file, "-o", tmp_path / "a.png", "--dry-run")
    assert result.code == 0 and result.out.decode() == f"{box_file} -> {tmp_path}/a.png (png)\n"
    assert os.listdir(tmp_path) == []


def test_verbose_says_where_the_time_went(run: Run, box_file: Path, tmp_path: Path) -> None:
    result = run("render", box_file, "-o", tmp_path / "a.png", "--size", "9", "-v")
    assert "6 of 6 faces drawn" in result.err and "trace" in result.err and result.out == b""


@pytest.mark.parametrize("mode", ["plain", "json"])
def test_progress_goes_to_stderr(run: Run, box_file: Path, tmp_path: Path, mode: str) -> None:
    arguments = (
        "render",
        box_file,
        "-o",
        tmp_path / "a.png",
        "--size",
        "9",
        "--progress",
        mode,
        "--no-cache",
    )
    result = run(*arguments)
    assert result.code == 0 and result.out == b""
    lines = result.err.splitlines()
    if mode == "json":
        assert {json.loads(line)["event"] for line in lines} == {"progress"}
        assert json.loads(lines[-1])["stage"] == "write"
    else:
        assert all("box.step: " in line for line in lines) and "write" in lines[-1]


def test_a_bar_shows_on_a_terminal_after_a_second(monkeypatch: pytest.MonkeyPatch, capfd: object) -> None:
    import io

    from trimray.cli import progress

    screen = io.StringIO()
    screen.isatty = lambda: True  # type: ignore[method-assign]
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setattr(progress, "_BAR_AFTER_SECONDS", 0.0)
    with progress.progress_of("part.step", "auto", quiet=False) as sink:
        sink("trace", 0.5)
        sink._timer.join()  # type: ignore[attr-defined]
    assert "part.step: trace" in screen.getvalue()
    screen.truncate(0)
    with progress.progress_of("part.step", "auto", quiet=True) as sink:
        assert not hasattr(sink, "_timer")
    monkeypatch.setattr(progress, "_BAR_AFTER_SECONDS", 3600.0)
    with progress.progress_of("part.step", "auto", quiet=False) as sink:
        sink("trace", 0.5)
    assert screen.getvalue() == ""
