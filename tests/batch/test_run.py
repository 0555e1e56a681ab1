"""What a run draws, what it leaves alone, and what it remembers; with a stand-in for the pool."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from trimray import OutputError, UsageError
from trimray.batch import Item, Outcome, Settings, Summary, run
from trimray.batch.report import lines
from trimray.batch.run import NOTHING_FOUND
from trimray.batch.state import State

from .run_stand_in import Drawer, Told, rows


def test_a_run_draws_all_and_remembers_each(go: Callable[..., Summary], draw: Drawer, tmp_path: Path) -> None:
    told = Told()
    summary = go(listener=told)
    assert draw.names == ["a.step", "b.step", "c.stl", "d.step"] and draw.closed
    assert (summary.total, summary.drawn, summary.skipped, summary.failed) == (4, 4, 0, 1)
    assert summary.exit_code == 1 and summary.statuses == {"complete": 3, "failed": 1}
    assert told.total == 4 and len(told.was_drawn) == 4 and told.was_skipped == []
    assert (tmp_path / "out/sub/b.png").read_text() == "good b"
    kept = rows(summary)
    assert kept["b.step"].target == "sub/b.png" and kept["b.step"].status == "complete"
    assert kept["c.stl"].reason == "no model" and kept["c.stl"].exit_code == 3
    assert all(row.attempt == 1 and row.finished for row in kept.values())


def test_unchanged_files_stay_and_changed_ones_are_drawn_again(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    go()
    assert draw.names
    told = Told()
    again = go(listener=told)
    assert draw.names == []
    assert (again.total, again.drawn, again.skipped, again.exit_code) == (4, 0, 4, 1)
    assert {o.status for o in told.was_skipped} == {"complete", "failed"}
    (library / "a.step").write_text("good A")  # of the same size
    os.utime(library / "sub/b.step", (1, 1))  # the same bytes
    (library / "e.step").write_text("good e")
    summary = go()
    assert draw.names == ["a.step", "e.step"]
    assert summary.total == 5 and rows(summary)["b.step"].mtime_ns == 10**9


def test_the_date_is_no_proof_but_for_resume(go: Callable[..., Summary], draw: Drawer, library: Path) -> None:
    go()
    assert draw.names
    before = (library / "a.step").stat()
    (library / "a.step").write_text("good A")
    os.utime(library / "a.step", ns=(before.st_atime_ns, before.st_mtime_ns))
    go(resume=True)
    assert draw.names == []
    go()
    assert draw.names == ["a.step"]


def test_what_makes_other_pictures_draws_all_again(go: Callable[..., Summary], draw: Drawer) -> None:
    go()
    assert len(draw.names) == 4
    go(settings=Settings(cache=True))
    assert draw.names == []
    go(settings=Settings(size=(64, 64)))
    assert len(draw.names) == 4


def test_another_version_draws_all_again(
    go: Callable[..., Summary], draw: Drawer, monkeypatch: pytest.MonkeyPatch
) -> None:
    go()
    assert draw.names
    monkeypatch.setattr("trimray.batch.work.__version__", "99")
    go()
    assert len(draw.names) == 4


def test_missing_and_empty_pictures_are_drawn_again(
    go: Callable[..., Summary], draw: Drawer, tmp_path: Path
) -> None:
    go()
    assert draw.names
    (tmp_path / "out/a.png").unlink()
    (tmp_path / "out/d.png").write_bytes(b"")
    go()
    assert draw.names == ["a.step", "d.step"]


def test_failures_are_tried_again_on_request_alone(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    (library / "e.step").write_text("crash")
    (library / "f.step").write_text("degraded")
    go()
    assert draw.names
    go()
    assert draw.names == []
    summary = go(retry_failed=True)
    assert draw.names == ["c.stl", "e.step", "f.step"]
    kept = rows(summary)
    assert {name: row.attempt for name, row in kept.items()} == {
        "a.step": 1, "b.step": 1, "c.stl": 2, "d.step": 1, "e.step": 2, "f.step": 2,
    }  # fmt: skip
    (library / "c.stl").write_text("bad again")
    assert rows(go())["c.stl"].attempt == 1


def test_what_could_not_be_written_is_tried_again(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    (library / "c.stl").write_text("full")
    go()
    assert len(draw.names) == 4
    go()
    assert draw.names == ["c.stl"]


def test_the_hash_of_a_crashing_file_is_known_too(go: Callable[..., Summary], library: Path) -> None:
    (library / "a.step").write_text("crash")
    assert rows(go())["a.step"].sha256 == hashlib.sha256(b"crash").hexdigest()


def test_unreadable_files_fail_with_their_reason_until_they_can_be_read(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    (library / "a.step").unlink()
    (library / "a.step").symlink_to("nowhere")
    summary = go()
    assert rows(summary)["a.step"].reason == "No such file or directory"
    assert draw.names
    go()
    assert draw.names == []
    (library / "nowhere").write_text("good")
    assert go().statuses["complete"] == 3
    assert draw.names == ["a.step"]


def test_a_picture_of_what_fails_now_is_removed(
    go: Callable[..., Summary], library: Path, tmp_path: Path
) -> None:
    go()
    assert (tmp_path / "out/a.png").exists()
    (library / "a.step").write_text("bad")
    summary = go()
    assert not (tmp_path / "out/a.png").exists()
    assert rows(summary)["a.step"].status == "failed"


def test_files_that_are_gone_are_forgotten_and_their_pictures_stay(
    go: Callable[..., Summary], library: Path, tmp_path: Path
) -> None:
    go()
    (library / "a.step").unlink()
    told = Told()
    summary = go(listener=told)
    assert summary.total == 3 and "a.step" not in rows(summary)
    assert (tmp_path / "out/a.png").exists()
    assert any("no longer there; its picture stays: a.png" in note for note in told.notes)


def test_a_run_speaks_of_its_own_paths_and_forgets_no_others(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    go()
    assert draw.names
    part = go([str(library / "sub")])
    assert part.total == 1 and part.exit_code == 0
    assert draw.names == ["b.step"]  # its picture has another place now
    whole = go()
    assert whole.total == 4 and draw.names == ["b.step"]


def test_an_interrupted_run_is_gone_on_with(go: Callable[..., Summary], draw: Drawer, tmp_path: Path) -> None:
    draw.stop_after = 2
    with pytest.raises(KeyboardInterrupt):
        go(settings=Settings(size=(64, 48)), include=["*.s*"])
    assert draw.closed and len(draw.names) == 2
    with State(str(tmp_path / "out/trimray-batch.sqlite")) as state:
        last = state.last_run()
        assert last is not None and not last.finished
        counts = state.counts(last.id)
        assert sum(counts.values()) == 4 and counts[("pending", 0)] == 2
    draw.stop_after = None
    summary = go([], resume=True)
    assert len(draw.names) == 2 and summary.skipped == 2 and summary.total == 4
    assert {json.loads(row.settings)["size"][1] for row in rows(summary).values()} == {48}
    with State(summary.state) as state:
        last = state.last_run()
    assert last is not None and last.finished and last.options["include"] == ["*.s*"]


def test_an_interrupted_run_has_a_gallery_of_what_is_done(
    go: Callable[..., Summary], draw: Drawer, tmp_path: Path
) -> None:
    draw.stop_after = 2
    with pytest.raises(KeyboardInterrupt):
        go(gallery=True)
    page = (tmp_path / "out/index.html").read_text()
    shown = [name for name in ("a.step", "b.step", "c.stl", "d.step") if name in page]
    assert len(shown) == 2 and shown == draw.names
    draw.stop_after = None
    go([], resume=True)
    page = (tmp_path / "out/index.html").read_text()
    assert all(name in page for name in ("a.step", "b.step", "c.stl", "d.step"))


def test_an_interrupted_retry_is_gone_on_with(
    go: Callable[..., Summary], draw: Drawer, library: Path
) -> None:
    (library / "e.step").write_text("bad e")
    go()
    assert draw.names
    draw.stop_after = 1
    with pytest.raises(KeyboardInterrupt):
        go(retry_failed=True)
    first = draw.names
    draw.stop_after = None
    go([], resume=True)
    assert sorted(first + draw.names) == ["c.stl", "e.step"]


def test_half_pictures_of_a_killed_run_are_removed(
    go: Callable[..., Summary], draw: Drawer, library: Path, tmp_path: Path
) -> None:
    draw.stop_after = 0
    with pytest.raises(KeyboardInterrupt):
        go()
    (tmp_path / "out/sub").mkdir()
    half = tmp_path / "out/sub/.b.png.0123456789ab.part"
    foreign = tmp_path / "out/sub/.x.png.0123456789ab.part"
    for path in (half, foreign):
        path.write_bytes(b"half")
    draw.stop_after = None
    go(resume=True)
    assert foreign.exists() and not half.exists()


def test_a_file_of_which_nothing_is_heard_is_a_failure(library: Path, draw: Drawer, tmp_path: Path) -> None:
    def deaf(items: Iterable[Item], settings: Settings) -> Iterator[Outcome]:
        return (outcome for outcome in draw(items, settings) if not outcome.path.endswith("a.step"))

    summary = run([str(library)], str(tmp_path / "out"), draw=deaf)
    assert summary.statuses == {"complete": 2, "failed": 2}
    assert rows(summary)["a.step"].exit_code == 70 and "nothing was heard" in rows(summary)["a.step"].reason


def test_folders_that_cannot_be_searched_count(
    go: Callable[..., Summary], library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (library / "c.stl").unlink()
    scandir = os.scandir

    def refuse(path: str) -> object:
        if str(path).endswith("/sub"):
            raise PermissionError(13, "Permission denied")
        return scandir(path)

    monkeypatch.setattr("os.scandir", refuse)
    told = Told()
    summary = go(listener=told)
    assert summary.exit_code == 1 and summary.statuses == {"complete": 2, "failed": 1}
    assert "Permission denied" in rows(summary)["sub"].reason
    assert told.total == 3 and len(told.was_drawn) == 3


def test_exit_codes(go: Callable[..., Summary], library: Path, tmp_path: Path) -> None:
    assert go([str(library / "a.step")]).exit_code == 0
    assert go([str(library / "a.step"), str(library / "c.stl")]).exit_code == 1
    assert go([str(library / "c.stl")]).exit_code == 3
    empty = tmp_path / "empty"
    empty.mkdir()
    summary = go([str(empty)])
    assert summary.exit_code == NOTHING_FOUND and summary.total == 0
    assert go([str(library)], include=["*.nothing"]).exit_code == NOTHING_FOUND


def test_wrong_words_are_refused_before_anything_is_made(
    go: Callable[..., Summary], library: Path, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="missing input"):
        go([])
    with pytest.raises(UsageError, match="unknown field"):
        go(template="{x}")
    with pytest.raises(UsageError, match="no transparency"):
        go(settings=Settings(format="jpeg", background="transparent"))
    with pytest.raises(OutputError, match="no such state"):
        go([], resume=True)
    assert not (tmp_path / "out").exists()
    with pytest.raises(UsageError, match="overwrite the input"):
        run([str(library)], str(library), include=["*"], template="{parent}/{name}.{ext}", draw=Drawer())
    assert (library / "a.step").read_text() == "good a"
    with pytest.raises(OutputError, match="not made"):
        run([str(library)], str(library / "a.step"), draw=Drawer())


def test_pictures_may_stand_beside_their_files(library: Path, draw: Drawer) -> None:
    for _ in range(2):
        assert run([str(library)], str(library), draw=draw).total == 4
    assert (library / "sub/b.png").exists() and len(draw.names) == 4


def test_the_report_has_a_line_a_file_in_order(go: Callable[..., Summary], library: Path) -> None:
    odd = os.fsdecode(b"caf\xe9\n.step")
    (library / odd).write_text("good")
    summary = go()
    with State(summary.state) as state:
        text = b"".join(lines(state.rows(summary.run), os.path.dirname(summary.state)))
    assert text.isascii() and text.endswith(b"\n")
    entries = [json.loads(line) for line in text.splitlines()]
    assert [os.path.basename(e["input"]) for e in entries] == ["a.step", "c.stl", odd, "d.step", "b.step"]
    assert os.path.exists(entries[2]["output"]) and entries[1]["output"] is None
    assert entries[1] | {"status": "failed", "exit_code": 3, "reason": "no model", "size": 5} == entries[1]
    assert entries[0]["settings"]["size"] == [256, 256] and entries[0]["drawn"] == 6


def test_reasons_do_not_repeat_the_path(go: Callable[..., Summary], library: Path, draw: Drawer) -> None:
    def wordy(items: Iterable[Item], settings: Settings) -> Iterator[Outcome]:
        for item in items:
            yield replace(Outcome(item.path, item.target, "failed", 3), reason=f"{item.path}: bad")

    summary = run([str(library)], str(library.parent / "out"), draw=wordy)
    assert {row.reason for row in rows(summary).values()} == {"bad"}
