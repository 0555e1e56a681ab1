"""The state keeps what it was told, whatever happens to the process, and belongs to one at a time."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from trimray import OutputError
from trimray.batch.record import Outcome, Settings
from trimray.batch.state import SCHEMA, State

KEY = Settings().key()
ODD = os.fsdecode(b"/lib/caf\xe9 \n'\".step")


def outcome(path: str = "/lib/a.step", **changes: object) -> Outcome:
    whole = Outcome(path, "/out/a.png", "partial", 1, "2 faces missing", "ab" * 32, 1.5, 1 << 33, 7, 2, 0.25)
    return replace(whole, **changes)  # type: ignore[arg-type]


def record(state: State, run: int, told: Outcome, target: str = "a.png") -> None:
    state.record(run, told, target, size=5, mtime_ns=1 << 60, settings=KEY, attempt=3)


def test_a_row_says_what_was_recorded(tmp_path: Path) -> None:
    place = str(tmp_path / "s.sqlite")
    told = outcome(ODD, reason=f"{ODD}: bad")
    with State(place) as state:
        run = state.begin(["/lib", ODD], {"size": [1, 2]})
        record(state, run, told, ODD[1:])
        state.finish(run)
    with State(place, create=False) as state:
        row = state.row(ODD)
        last = state.last_run()
    assert row is not None and last is not None
    assert (row.path, row.target, row.attempt, row.size, row.mtime_ns) == (ODD, ODD[1:], 3, 5, 1 << 60)
    assert row.settings == KEY and row.version and row.finished.endswith("Z")
    back = row.outcome("/out")
    assert back == replace(told, target=os.path.join("/out", ODD[1:]), reason=row.reason)
    assert row.reason == "/lib/caf\\udce9 \n'\".step: bad"
    assert last.paths == ("/lib", ODD) and last.options == {"size": [1, 2]} and last.finished


def test_a_file_is_pending_until_it_is_recorded(tmp_path: Path) -> None:
    with State(str(tmp_path / "s.sqlite")) as state:
        run = state.begin([], {})
        state.enroll(run, "/lib/a.step", "a.png", pending=True)
        row = state.row("/lib/a.step")
        assert row is not None and row.status == "pending" and row.outcome("/out") is None
        record(state, run, outcome())
        again = state.begin([], {})
        state.enroll(again, "/lib/a.step", "b.png", pending=False)
        row = state.row("/lib/a.step")
        assert row is not None and (row.status, row.target, row.attempt) == ("partial", "b.png", 3)
        state.enroll(again, "/lib/a.step", "b.png", pending=True)
        assert state.counts(again) == {("pending", 1): 1} and state.counts(run) == {}


def test_rows_come_by_path_and_run(tmp_path: Path) -> None:
    with State(str(tmp_path / "s.sqlite")) as state:
        old = state.begin([], {})
        record(state, old, outcome("/lib/z.step"))
        run = state.begin([], {})
        for path in ("/lib/b", ODD, "/lib/B", "/lib/a/x"):
            record(state, run, outcome(path))
        paths = [row.path for row in state.rows(run)]
    assert paths == sorted(["/lib/b", ODD, "/lib/B", "/lib/a/x"], key=os.fsencode)


def test_rows_of_files_that_are_gone_are_forgotten(tmp_path: Path) -> None:
    there = tmp_path / "there.step"
    there.write_bytes(b"x")
    with State(str(tmp_path / "s.sqlite")) as state:
        old = state.begin([], {})
        record(state, old, outcome(str(there)))
        record(state, old, outcome("/lib/gone.step"))
        record(state, old, outcome("/lib/gone but in the run.step"))
        run = state.begin([], {})
        state.enroll(run, "/lib/gone but in the run.step", "x", pending=False)
        assert [row.path for row in state.forget_gone(run)] == ["/lib/gone.step"]
        assert state.row(str(there)) and state.row("/lib/gone but in the run.step")
        assert state.row("/lib/gone.step") is None


def test_changes_together_are_all_or_none(tmp_path: Path) -> None:
    with State(str(tmp_path / "s.sqlite")) as state:
        run = state.begin([], {})
        with pytest.raises(KeyboardInterrupt), state.together():
            record(state, run, outcome())
            raise KeyboardInterrupt
        assert state.row("/lib/a.step") is None
        with state.together():
            record(state, run, outcome())
        assert state.row("/lib/a.step") is not None


_DIES = """
import os, signal, sys
from trimray.batch.record import Outcome
from trimray.batch.state import State
state = State(sys.argv[1])
run = state.begin(["/lib"], {})
for k in range(200):
    told = Outcome(f"/lib/{k}", "", "complete")
    state.record(run, told, f"{k}.png", size=1, mtime_ns=1, settings="{}", attempt=1)
print("recorded", flush=True)
if sys.argv[2] == "die":
    os.kill(os.getpid(), signal.SIGKILL)
sys.stdin.read()
"""


def test_a_killed_process_loses_nothing_and_leaves_no_lock(tmp_path: Path) -> None:
    place = str(tmp_path / "s.sqlite")
    done = subprocess.run([sys.executable, "-c", _DIES, place, "die"], capture_output=True, check=False)
    assert done.returncode == -9 and done.stdout == b"recorded\n"
    with State(place) as state:
        last = state.last_run()
        assert last is not None and not last.finished
        assert state.counts(last.id) == {("complete", 0): 200}


def test_a_second_batch_on_the_folder_is_refused(tmp_path: Path) -> None:
    place = str(tmp_path / "s.sqlite")
    other = subprocess.Popen(
        [sys.executable, "-c", _DIES, place, "stay"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        assert other.stdout is not None and other.stdout.readline() == b"recorded\n"
        with pytest.raises(OutputError, match="another batch is at work"):
            State(place)
    finally:
        other.communicate()
    with State(place) as state, pytest.raises(OutputError, match="another batch is at work"):
        assert state.last_run()
        State(place)


@pytest.mark.parametrize("content", [b"not a database, but long enough to be one" * 50, b"x"])
def test_a_foreign_file_is_one_clear_line(tmp_path: Path, content: bytes) -> None:
    place = tmp_path / "s.sqlite"
    place.write_bytes(content)
    with pytest.raises(OutputError, match=r"damaged.*move it away"):
        State(str(place))
    assert place.read_bytes() == content


def test_a_database_of_something_else_is_left_alone(tmp_path: Path) -> None:
    place = tmp_path / "s.sqlite"
    base = sqlite3.connect(place)
    base.execute("CREATE TABLE mine (x)")
    base.close()
    with pytest.raises(OutputError, match="not the state of a batch"):
        State(str(place))


def test_a_newer_schema_is_refused(tmp_path: Path) -> None:
    place = tmp_path / "s.sqlite"
    State(str(place)).close()
    base = sqlite3.connect(place)
    base.execute(f"PRAGMA user_version = {SCHEMA + 1}")
    base.close()
    with pytest.raises(OutputError, match="newer trimray"):
        State(str(place))


def test_damage_within_is_one_clear_line(tmp_path: Path) -> None:
    """Whatever page is overwritten: an OutputError, or rows that can be read."""
    place = tmp_path / "s.sqlite"
    with State(str(place)) as state, state.together():
        run = state.begin(["/lib"], {})
        for k in range(2000):
            record(state, run, outcome(f"/lib/{k}.step"))
    whole = bytearray(place.read_bytes())
    refused = 0
    for at in range(0, len(whole), len(whole) // 20):
        damaged = whole.copy()
        damaged[at : at + 4096] = b"\x5a" * len(damaged[at : at + 4096])
        place.write_bytes(damaged)
        try:
            with State(str(place)) as state:
                sum(1 for _ in state.rows(run))
                state.counts(run)
        except OutputError as error:
            refused += 1
            assert "\n" not in str(error) and str(place) in str(error)
    assert refused > 0


def test_a_place_that_cannot_be_written_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="unable to open"):
        State(str(tmp_path / "missing" / "s.sqlite"))
    with pytest.raises(OutputError, match="no such state"):
        State(str(tmp_path / "s.sqlite"), create=False)
