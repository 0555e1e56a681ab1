"""The command: real files through the real pool, and what stands on the terminal."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import Run, process

SMALL = ("--size", "32", "-j", "2")


@pytest.fixture
def library(tmp_path: Path, samples_dir: Path) -> Path:
    """Four files that are drawn, of which two want the same picture, and two that are not."""
    folder = tmp_path / "lib"
    (folder / "sub").mkdir(parents=True)
    for source, name in (
        ("bracket.step", "part.step"),
        ("bracket.brep", "part.brep"),
        ("stand.stl", "sub/stand.STL"),
        ("patch.step", "sub/new\nline \x1b[31m.step"),
    ):
        (folder / name).write_bytes((samples_dir / source).read_bytes())
    (folder / "empty.step").write_bytes(b"")
    (folder / "noise.igs").write_bytes(bytes(range(256)) * 9)
    return folder


def test_a_library_is_drawn_and_each_failure_named(run: Run, library: Path, tmp_path: Path) -> None:
    report = tmp_path / "r.jsonl"
    result = run("batch", library, "-o", tmp_path / "out", *SMALL, "--report", report)
    assert result.code == 1 and result.out == b""
    lines = result.err.splitlines()
    assert sorted(line.split(":")[1] for line in lines[:-1]) == [
        f" {library}/empty.step",
        f" {library}/noise.igs",
    ]
    assert all("failed: " in line for line in lines[:-1])
    assert "6 files: 4 complete, 2 failed; 6 drawn in" in lines[-1]
    out = tmp_path / "out"
    for name in ("part.step.png", "part.brep.png", "sub/stand.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG"), name
    entries = [json.loads(line) for line in report.read_text().splitlines()]
    assert len(entries) == 6 and [e["input"] for e in entries] == sorted(e["input"] for e in entries)
    assert {e["status"] for e in entries} == {"complete", "failed"}
    assert all(bool(e["reason"]) == (e["status"] == "failed") for e in entries)
    assert not [name for name in os.listdir(out) if name.endswith(".part")]

    again = run("batch", library, "-o", out, *SMALL, "-q")
    assert again.code == 1 and again.err == ""  # what failed before was told before
    resumed = run("batch", "--resume", "-o", out, "-vv")
    assert resumed.code == 1 and "6 of them unchanged; 0 drawn" in resumed.err
    assert "new\\nline \\x1b[31m.step: unchanged, complete" in resumed.err
    report_again = run("batch", "--resume", "-o", out, "-q", "--report", "-")
    assert report_again.out == report.read_bytes()


def test_the_format_is_the_one_asked_for(run: Run, samples_dir: Path, tmp_path: Path) -> None:
    for words, name, magic in (
        (("--format", "jpg"), "patch.jpg", b"\xff\xd8"),
        (("--format", "webp"), "patch.webp", b"RIFF"),
        (("--template", "x/{name}_{ext}.jpg"), "x/patch_step.jpg", b"\xff\xd8"),
    ):
        result = run("batch", samples_dir / "patch.step", "-o", tmp_path / "out", *SMALL, *words)
        assert result.code == 0, result.err
        assert (tmp_path / "out" / name).read_bytes().startswith(magic)


def test_a_dry_run_says_what_would_be_drawn(run: Run, library: Path, tmp_path: Path) -> None:
    result = run("batch", library, "-o", tmp_path / "out", "--dry-run", "--include", "*.step")
    assert result.code == 0 and not (tmp_path / "out").exists()
    lines = result.out.decode().splitlines()
    assert len(lines) == 3
    assert f"{library}/part.step -> {tmp_path}/out/part.png" in lines
    assert any("new\\nline \\x1b[31m.step -> " in line for line in lines)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["lib"], "missing output: give -o DIR"),
        (["-o", "out"], "missing input"),
        (["-", "-o", "out"], "not stdin"),
        (["lib", "-o", "out", "--template", "{nme}.png"], "did you mean 'name'"),
        (["lib", "-o", "out", "--template", "../{name}.png"], "leaves the folder"),
        (["lib", "-o", "out", "--shard", "3/2"], "--shard"),
        (["lib", "-o", "out", "-j", "two"], "not a number of processes"),
        (["lib", "-o", "out", "--format", "jpg", "--background", "transparent"], "no transparency"),
        (["-o", "out", "--resume"], "no run to go on with"),
        (["merge"], "takes one DIR"),
        (["merge", "lib", "-o", "out"], "./merge"),
        (["merge", "lib"], "no state of a shard"),
    ],
)
def test_wrong_usage_is_one_line(
    run: Run, library: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], message: str
) -> None:
    monkeypatch.chdir(library.parent)
    result = run("batch", *words)
    assert result.code == 2 and message in result.err and result.err.count("\n") == 1
    assert not (library.parent / "out").exists()


def test_a_folder_named_merge_can_be_reached(
    run: Run, samples_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "merge").mkdir()
    (tmp_path / "merge/a.step").write_bytes((samples_dir / "patch.step").read_bytes())
    monkeypatch.chdir(tmp_path)
    assert run("batch", "./merge", "-o", "out", *SMALL).code == 0
    assert (tmp_path / "out/a.png").exists()


def test_no_file_is_an_exit_code_of_its_own(run: Run, tmp_path: Path) -> None:
    result = run("batch", tmp_path, "-o", tmp_path / "out")
    assert result.code == 6 and "no file found" in result.err


def test_a_file_that_is_not_there_fails(run: Run, tmp_path: Path) -> None:
    result = run("batch", tmp_path / "missing.step", "-o", tmp_path / "out", *SMALL)
    assert result.code == 3 and "missing.step: failed: No such file" in result.err


def test_job_arrays_are_obeyed_and_merged(
    run: Run, library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    for name, value in (("COUNT", 2), ("MIN", 0), ("MAX", 1), ("ID", 0)):
        monkeypatch.setenv(f"SLURM_ARRAY_TASK_{name}", str(value))
    first = run("batch", library, "-o", out, *SMALL)
    assert "shard 1/2, as SLURM_ARRAY_TASK_ID says" in first.err
    missing = run("batch", "merge", out)
    assert missing.code == 1 and "shards missing: 2/2" in missing.err
    second = run("batch", library, "-o", out, *SMALL, "--shard", "2/2")
    assert "SLURM" not in second.err
    merged = run("batch", "merge", out, "--report", "-")
    assert merged.code == 1 and "6 files: 4 complete, 2 failed" in merged.err
    assert len(merged.out.splitlines()) == 6
    whole = run("batch", library, "-o", out, *SMALL, "--shard", "1/1")
    assert "6 of them unchanged; 0 drawn" in whole.err


def test_progress_as_lines(run: Run, library: Path, tmp_path: Path) -> None:
    result = run("batch", library, "-o", tmp_path / "out", *SMALL, "--progress", "json")
    *events, summary = [json.loads(line) for line in result.err.splitlines()]
    assert events[-1] | {"event": "progress", "done": 6, "total": 6, "failed": 2} == events[-1]
    assert events[-1]["files_per_second"] > 0 and events[-1]["seconds_left"] == 0
    files = {event["input"]: event for event in events if event["event"] == "file"}
    assert sorted(files) == [f"{library}/empty.step", f"{library}/noise.igs"]
    assert all(e["status"] == "failed" and e["level"] == "error" and e["reason"] for e in files.values())
    assert (summary["event"], summary["exit_code"]) == ("summary", 1)
    assert summary["statuses"] == {"complete": 4, "failed": 2} and summary["total"] == summary["drawn"] == 6
    assert summary["text"].startswith("6 files: 4 complete, 2 failed; 6 drawn in")
    result = run("batch", library, "-o", tmp_path / "out", *SMALL, "--progress", "plain")
    assert "6 of 6 files, 2 failed, -, 0 s left" in result.err


def test_options_have_defaults_of_their_own_here(run: Run) -> None:
    text = run("batch", "--print-config").out.decode()
    for line in ('size = "256,256"', "time_limit = 30.0", f"memory_limit = {2 << 30}", "cache = false"):
        assert line in text, line
    assert 'size = "512,512"' in run("render", "--print-config").out.decode()
    assert "# time_limit is not set" in run("batch", "--print-config", "--time-limit", "none").out.decode()


@pytest.fixture
def slow_library(tmp_path: Path, samples_dir: Path) -> Path:
    folder = tmp_path / "slow"
    folder.mkdir()
    data = (samples_dir / "bracket.step").read_bytes()
    for k in range(60):
        (folder / f"{k}.step").write_bytes(data)
    return folder


def pictures(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.png")) if folder.is_dir() else []


@pytest.fixture
def long_run(slow_library: Path, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """In the middle of its work."""
    command = [sys.executable, "-m", "trimray.cli", "batch", slow_library, "-o", tmp_path / "out", *SMALL]
    command += ["--gallery", "--report", tmp_path / "r.jsonl"]
    child = subprocess.Popen(
        [str(word) for word in command],
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        until = time.monotonic() + 240
        while len(pictures(tmp_path / "out")) < 4 and time.monotonic() < until:
            time.sleep(0.01)
        yield child
    finally:
        child.kill()
        child.wait()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_says_how_to_go_on(
    long_run: subprocess.Popen[str], tmp_path: Path, number: signal.Signals
) -> None:
    long_run.send_signal(number)
    _, err = long_run.communicate(timeout=120)
    assert long_run.returncode == 130
    told, gallery = err.splitlines()
    assert "of 60 files are done; go on with --resume" in told and gallery.endswith("out/index.html")
    entries = [json.loads(line) for line in (tmp_path / "r.jsonl").read_text().splitlines()]
    done = {Path(entry["output"]).name for entry in entries if entry["status"] == "complete"}
    assert len(entries) == 60 and 0 < len(done) < 60
    # One may have been kept in that very moment, and not been counted yet.
    assert any(f"interrupted: {count} of 60" in told for count in (len(done), len(done) - 1)), told
    assert set(re.findall(r'"(\d+\.png)"', (tmp_path / "out/index.html").read_text())) == done
    assert done <= {path.name for path in pictures(tmp_path / "out")}
    assert not [name for name in os.listdir(tmp_path / "out") if name.endswith(".part")]


def test_a_signal_to_all_processes_is_no_failure_of_a_file(
    long_run: subprocess.Popen[str], tmp_path: Path
) -> None:
    """As batch systems and service managers send SIGTERM; the supervisor, which decides, may get it last."""
    seen: set[int] = set()
    until = time.monotonic() + 3
    while time.monotonic() < until and long_run.poll() is None:
        for pid in descendants(long_run.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
                seen.add(pid)
        time.sleep(0.02)
    _, err = long_run.communicate(timeout=200)
    assert len(seen) >= 3
    assert long_run.returncode == 0 and "60 files: 60 complete" in err


def descendants(pid: int) -> list[int]:
    children: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(stat.parent.name))
    found = children.get(pid, [])
    for child in found:
        found += children.get(child, [])
    return found


def test_a_killed_batch_goes_on_where_it_was(long_run: subprocess.Popen[str], tmp_path: Path) -> None:
    long_run.kill()
    long_run.wait()
    out = tmp_path / "out"
    before = {path.name: path.stat().st_mtime_ns for path in pictures(out)}
    done = process("batch", "--resume", "-o", out, "-j", "2", "--report", "-")
    assert done.code == 0 and "60 files: 60 complete" in done.err
    redone = [p.name for p in pictures(out) if p.name in before and p.stat().st_mtime_ns != before[p.name]]
    assert len(redone) <= 2  # at most one a worker
    assert len(done.out.splitlines()) == 60 == len(pictures(out))
