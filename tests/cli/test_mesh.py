"""trimray mesh, and several inputs in one output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import trimray

from .conftest import Run


@pytest.fixture
def stand(box_file: Path, tmp_path: Path) -> Path:
    path = tmp_path / "stand.stl"
    trimray.load(box_file).tessellate().save(path)
    return path


@pytest.mark.parametrize("format", ["stl", "ply", "obj", "off"])
def test_a_mesh_is_written_in_the_format_of_the_extension(
    run: Run, ball_file: Path, tmp_path: Path, format: str
) -> None:
    out = tmp_path / f"ball.{format}"
    result = run("mesh", ball_file, "-o", out, "--deviation", "0.01mm", "-v")
    assert result.code == 0
    assert "0 open and 0 non-manifold edges, 0 degenerate triangles" in result.err
    piped = run("mesh", ball_file, "-o", "-", "--format", format, "--deviation", "0.01", "-j", "1")
    assert piped.out == out.read_bytes()
    assert run("info", out).code == 0


def test_an_angle_makes_a_mesh_finer(run: Run, ball_file: Path) -> None:
    coarse = run("mesh", ball_file, "-o", "-").out
    fine = run("mesh", ball_file, "-o", "-", "--angle", "5").out
    assert len(fine) > len(coarse) > 84


def test_a_deviation_in_pixels_is_that_of_a_picture(run: Run, ball_file: Path) -> None:
    view = ("--view", "top", "--projection", "perspective", "--up", "y")
    small = run("mesh", ball_file, "-o", "-", "--deviation", "0.3px", "--size", "64", *view, "-v")
    large = run("mesh", ball_file, "-o", "-", "--deviation", "0.3px", "--size", "640,480", *view)
    assert (small.code, large.code) == (0, 0)
    assert "(0.3 px asked); 0 open" in small.err
    assert len(large.out) > 3 * len(small.out)


def test_several_inputs_and_one_file_are_one_scene(
    run: Run, ball_file: Path, stand: Path, tmp_path: Path
) -> None:
    out = tmp_path / "both.exr"
    result = run("render", ball_file, stand, "-o", out, "--aov", "color,instance", "--size", "64")
    assert (result.code, result.err) == (0, "")
    assert out.stat().st_size > 0
    mesh = tmp_path / "both.ply"
    assert run("mesh", ball_file, stand, "-o", mesh).code == 0
    parts = [trimray.load(p).tessellate().check().volume for p in (ball_file, stand)]
    assert trimray.load(mesh).tessellate().check().volume == pytest.approx(sum(parts), rel=1e-2)


def test_of_a_scene_what_cannot_be_read_is_named_and_the_rest_is_drawn(
    run: Run, ball_file: Path, stand: Path, tmp_path: Path
) -> None:
    out, missing = tmp_path / "both.png", tmp_path / "missing.step"
    broken = tmp_path / "broken.stl"
    broken.write_bytes(stand.read_bytes()[:-9])
    result = run("render", ball_file, missing, broken, stand, "-o", out, "--size", "32", "--report", "-")
    assert result.code == 1
    assert out.exists()
    assert "missing.step: No such file" in result.err and "broken.stl: STL: cut off" in result.err
    codes = [r["exit_code"] for r in json.loads(result.out)["results"]]
    assert codes == [0, 3, 3, 0]


def test_a_scene_of_which_nothing_can_be_read_is_not_drawn(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "both.png"
    result = run("render", tmp_path / "a.step", tmp_path / "b.stl", "-o", out)
    assert result.code == 3
    assert not out.exists()


def test_a_folder_takes_each_mesh_by_itself(run: Run, ball_file: Path, stand: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    assert run("mesh", ball_file, stand, "-o", folder, "--format", "off").code == 0
    assert sorted(p.name for p in folder.iterdir()) == ["ball.off", "stand.off"]


def test_triangles_through_stdin_and_with_a_note_about_their_unit(run: Run, stand: Path) -> None:
    result = run("render", stand, "-o", "-", "--size", "16", "-vv")
    assert result.code == 0
    assert "the format has no unit: lengths are taken as mm" in result.err
