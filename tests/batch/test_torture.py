"""A small library of hostile files: `scripts/verify batch` runs one of more than a thousand."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from .torture import library
from .torture.judge import Row, differences, judge, judge_end
from .torture.runs import SIZE, Setup, disturbed, singles, undisturbed, unplaced

PATIENCE = 600.0
# None of these mutants hangs.
MUTANTS, SEED = 26, 2


@pytest.fixture(scope="module")
def setup(tmp_path_factory: pytest.TempPathFactory) -> Setup:
    folder = tmp_path_factory.mktemp("torture")
    entries = library.build(folder / "library", mutants=MUTANTS, seed=SEED, small=True)
    return Setup(folder / "library", folder, entries)


@pytest.fixture(scope="module")
def rows(setup: Setup) -> dict[bytes, Row]:
    """Of a run that nothing disturbed."""
    _, problems = undisturbed(setup, "whole", PATIENCE)
    assert not problems
    return setup.rows("whole")


def test_the_library_is_the_same_for_the_same_seed(tmp_path: Path, setup: Setup) -> None:
    again = library.build(tmp_path / "again", mutants=MUTANTS, seed=SEED, small=True)
    assert again == setup.entries
    for entry in again:
        if entry.kind != "devices" and entry.kind != "links":
            assert (tmp_path / "again" / entry.shown).read_bytes() == (
                setup.library / entry.shown
            ).read_bytes()
    shutil.rmtree(tmp_path / "again")


def test_every_good_file_is_drawn_and_every_bad_one_named(setup: Setup, rows: dict[bytes, Row]) -> None:
    like = singles(setup.entries, setup.library, setup.folder)
    verdict = judge(setup.entries, rows, setup.output("whole"), SIZE, like=like)
    assert not verdict.problems


@pytest.mark.parametrize(
    ("how", "share"), [("group", 0.37), ("supervisor", 0.61), ("SIGINT", 0.23), ("SIGTERM", 0.5)]
)
def test_a_run_that_was_ended_goes_on_where_it_was(
    setup: Setup, rows: dict[bytes, Row], how: str, share: float
) -> None:
    problems, _ = disturbed(setup, how, "whole", how, share, PATIENCE)
    assert not problems


def test_a_second_run_draws_nothing(setup: Setup, rows: dict[bytes, Row]) -> None:
    done = setup.start("whole").wait(PATIENCE)
    assert not judge_end(done)
    assert not differences(unplaced(setup.rows("whole")), unplaced(rows))


def test_what_may_not_be_read_or_written_is_named(tmp_path: Path, samples_dir: Path) -> None:
    """Without the rights of root, from which nothing could be hidden."""
    bwrap = shutil.which("bwrap")
    words = [str(bwrap), "--unshare-user", "--uid", "1000", "--gid", "1000", "--cap-drop", "ALL"]
    words += ["--bind", "/", "/", "--dev-bind", "/dev", "/dev"]
    if bwrap is None or subprocess.run([*words, "true"], capture_output=True, check=False).returncode:
        pytest.skip("bubblewrap is not there, or may not make a user namespace")
    lib, out = tmp_path / "lib", tmp_path / "out"
    for name in ("a.step", "secret.step", "shut/b.step", "blind/c.step", "barred/d.step"):
        (lib / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(samples_dir / "torture" / "sphere.step", lib / name)
    (out / "barred").mkdir(parents=True)
    for path, mode in (
        (lib / "secret.step", 0),
        (lib / "shut", 0),
        (lib / "blind", 0o444),
        (out / "barred", 0o555),
    ):
        path.chmod(mode)

    def batch(*more: str) -> tuple[int, dict[str, str]]:
        report = tmp_path / "r.jsonl"
        batch_words = ["batch", str(lib), "-o", str(out), "-j", "1", "--size", "32", *more]
        command = [*words, sys.executable, "-m", "trimray.cli", *batch_words, "--report", str(report)]
        code = subprocess.run(command, capture_output=True, check=False).returncode
        rows = [json.loads(line) for line in report.read_text().splitlines()]
        return code, {os.path.relpath(row["input"], lib): row["status"] for row in rows}

    closed = ("secret.step", "shut", "blind/c.step", "barred/d.step")
    assert batch() == (1, {"a.step": "complete"} | dict.fromkeys(closed, "failed"))
    for path in (lib / "secret.step", lib / "shut", lib / "blind", out / "barred"):
        path.chmod(0o755)
    files = ("a.step", "secret.step", "shut/b.step", "blind/c.step", "barred/d.step")
    assert batch("--resume") == (0, dict.fromkeys(files, "complete"))
