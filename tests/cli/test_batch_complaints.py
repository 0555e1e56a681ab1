"""What stands in the way of a batch is said at once, in one line."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
from pathlib import Path

from .conftest import Run


def test_a_report_that_cannot_be_written_is_told_before_the_work(
    run: Run, samples_dir: Path, tmp_path: Path
) -> None:
    result = run("batch", samples_dir, "-o", tmp_path / "out", "--report", tmp_path / "none" / "r.jsonl")
    assert result.code == 4 and "no folder" in result.err and result.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_report_may_stand_beside_the_pictures(run: Run, tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "a.step").touch()
    out = tmp_path / "out"
    assert run("batch", tmp_path / "lib", "-o", out, "--report", out / "r.jsonl").code == 3
    assert (out / "r.jsonl").read_text().count("\n") == 1


def test_a_state_without_a_run_is_said_to_be_one(run: Run, tmp_path: Path) -> None:
    (tmp_path / "trimray-batch.sqlite").touch()
    result = run("batch", "-o", tmp_path, "--resume")
    assert result.code == 2 and "no run to go on with" in result.err


def test_options_of_a_run_that_are_damaged_are_no_internal_error(run: Run, tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    out = tmp_path / "out"
    assert run("batch", tmp_path / "lib", "-o", out).code == 6
    with sqlite3.connect(out / "trimray-batch.sqlite") as base:
        base.execute("UPDATE runs SET options = '{'")
    base.close()
    for more in ((), ("--resume",)):
        result = run("batch", *((tmp_path / "lib",) if not more else ()), "-o", out, *more)
        assert result.code == 4 and "damaged" in result.err


def test_a_closed_stdout_is_an_error_of_output(tmp_path: Path, samples_dir: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "trimray.cli", "info", "--json", str(samples_dir / "patch.step")],
        stderr=subprocess.PIPE,
        preexec_fn=lambda: os.close(1),
        check=False,
    )
    assert done.returncode == 4 and b"stdout: not written" in done.stderr


def test_a_picture_of_one_pixel_is_not_blank(run: Run, samples_dir: Path, tmp_path: Path) -> None:
    assert (
        run("batch", samples_dir / "torture/sphere.step", "-o", tmp_path, "--size", "1", "-j", "1").code == 0
    )
