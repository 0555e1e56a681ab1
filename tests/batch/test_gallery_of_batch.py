"""The gallery that a batch writes: of all files that its state knows."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from trimray import OutputError
from trimray.batch.draw import hash_file
from trimray.batch.gallery import write_gallery_of_state
from trimray.batch.record import Item, Outcome, Settings
from trimray.batch.run import run
from trimray.batch.state import State
from trimray.cli.__main__ import main

KEY = Settings(size=(320, 240), view="top").key()


def statuses(page: Path) -> dict[str, str]:
    """Of the files on the page, by name."""
    found = re.search(r'id="data">(.*?)</script>', page.read_text(encoding="utf-8"), re.S)
    assert found is not None
    data = json.loads(found[1])
    return {row[0]: data["statuses"][row[2]] for row in data["rows"]}


def record(state: State, run: int, outcome: Outcome, settings: str = KEY) -> None:
    target = Path(outcome.target).name
    state.record(run, outcome, target, size=7, mtime_ns=1, settings=settings, attempt=1)


def test_it_shows_files_of_all_runs_and_none_that_is_pending(tmp_path: Path) -> None:
    with State(str(tmp_path / "trimray-batch.sqlite")) as state:
        first, second = state.begin(["/in"], {}), state.begin(["/in"], {})
        record(state, first, Outcome("/in/a.step", f"{tmp_path}/a.png", "complete", drawn=6))
        record(state, second, Outcome("/in/b.step", f"{tmp_path}/b.png", "failed", 3, "empty"))
        state.enroll(second, "/in/c.step", "c.png", pending=True)
        page = Path(write_gallery_of_state(str(tmp_path), state))
    assert statuses(page) == {"a.step": "complete", "b.step": "failed"}
    assert "320 × 240 px · top" in page.read_text(encoding="utf-8")


def test_a_picture_is_shown_for_the_file_that_it_was_made_of_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = iter(f"2026-01-01T00:00:{second:02}.000Z" for second in range(60))
    monkeypatch.setattr("trimray.batch.state.now", lambda: next(times))
    with State(str(tmp_path / "trimray-batch.sqlite")) as state:
        for name in ("z", "a"):
            run = state.begin(["/in"], {})
            record(state, run, Outcome(f"/in/{name}/part.step", f"{tmp_path}/part.png", "complete"))
        other = Settings(view="front").key()
        record(state, run, Outcome("/in/a/other.step", f"{tmp_path}/other.png", "complete"), other)
        page = Path(write_gallery_of_state(str(tmp_path), state))
    assert statuses(page) == {"part.step": "complete", "other.step": "complete"}
    text = page.read_text(encoding="utf-8")
    assert '"root":"a"' in text
    assert " px" not in re.findall(r'id="note">(.*?)<', text)[0]  # the pictures have no settings in common


def batch(*words: object) -> int:
    return main(["batch", *map(str, words), "-q", "--size", "32", "-j", "2"])


def test_the_command_writes_it_also_when_it_goes_on(tmp_path: Path, samples_dir: Path) -> None:
    folder, page = tmp_path / "out", tmp_path / "out" / "index.html"
    inputs = tmp_path / "in"
    inputs.mkdir()
    for name in ("bracket.step", "patch.step"):
        (inputs / name).symlink_to(samples_dir / name)
    (inputs / "empty.step").touch()
    assert batch(inputs, "-o", folder) == 1
    assert not page.exists()
    assert main(["batch", "-o", str(folder), "--resume", "--gallery", "-q"]) == 1
    assert statuses(page) == {"bracket.step": "complete", "patch.step": "complete", "empty.step": "failed"}


def test_what_was_interrupted_has_it_of_what_is_done_and_of_all_in_the_end(
    tmp_path: Path, samples_dir: Path
) -> None:
    def interrupted(items: Iterable[Item], settings: Settings) -> Iterator[Outcome]:
        item = next(iter(items))
        yield Outcome(item.path, item.target, "failed", 3, "a reason", sha256=hash_file(item.path))
        raise KeyboardInterrupt

    inputs = [str(samples_dir / name) for name in ("patch.step", "stand.stl")]
    with pytest.raises(KeyboardInterrupt):
        run(inputs, str(tmp_path), Settings(size=(32, 32)), gallery=True, draw=interrupted)
    assert [*statuses(tmp_path / "index.html").values()] == ["failed"]
    assert main(["batch", "-o", str(tmp_path), "--resume", "-q"]) == 1
    assert sorted(statuses(tmp_path / "index.html").values()) == ["complete", "failed"]


def test_an_empty_batch_and_one_of_failures_have_one(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    assert batch(tmp_path / "in", "-o", tmp_path / "out", "--gallery") == 6
    assert statuses(tmp_path / "out" / "index.html") == {}
    (tmp_path / "in" / "a.step").write_text("nonsense")
    assert batch(tmp_path / "in", "-o", tmp_path / "out", "--gallery") == 3
    assert statuses(tmp_path / "out" / "index.html") == {"a.step": "failed"}


def test_shards_have_one_when_they_are_merged(
    tmp_path: Path, samples_dir: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    inputs = [samples_dir / name for name in ("bracket.step", "patch.step", "teapot.step")]
    folder = tmp_path / "out"
    assert batch(*inputs, "-o", folder, "--shard", "1/2", "--gallery") == 2
    assert "batch merge" in capsys.readouterr().err and not folder.exists()
    for k in (1, 2):
        assert batch(*inputs, "-o", folder, "--shard", f"{k}/2") == 0
    assert main(["batch", "merge", str(folder), "--gallery", "-q"]) == 0
    assert statuses(folder / "index.html") == {path.name: "complete" for path in inputs}


def test_a_page_of_someone_else_stops_a_batch_before_it_begins(
    tmp_path: Path, samples_dir: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "index.html").write_text("mine")
    assert batch(samples_dir / "patch.step", "-o", tmp_path, "--gallery") == OutputError.exit_code
    assert "index.html" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["index.html"]
