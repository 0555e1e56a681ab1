"""The pool: whatever a worker does costs the file that it was at, and nothing stays behind."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import trimray
from trimray.batch import fork_server, pool
from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Outcome, Settings

from . import misbehaving_draw

HERE = Path(__file__).parent
WITHOUT = Settings(time_limit=None)


def item(name: str, folder: Path = Path("/tmp"), milliseconds: int = 0) -> Item:
    return Item(f"/nowhere/{name}", str(folder / f"{name}.png"), milliseconds)


def run(items: list[Item], settings: Settings = WITHOUT, workers: int = 2, **more: object) -> list[Outcome]:
    return list(draw_all(items, settings, workers, draw=misbehaving_draw.draw, **more))


def until(what: Callable[[], bool], seconds: float = 120.0) -> bool:
    """Does it become true? The time is a bound for a hopeless case, on a machine under load."""
    deadline = time.monotonic() + seconds
    while not what():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


def processes(mark: str) -> set[int]:
    """Living processes that have the text in their command line; forked ones have their parent's."""
    found = set()
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                if mark.encode() in (entry / "cmdline").read_bytes():
                    found.add(int(entry.name))
    return found


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "GRACE_SECONDS", 0.5)


# What a worker does at a file -> exit code and what the reason holds.
BAD = {
    "segfault": (70, "crashed (SIGSEGV)"),
    "abort": (70, "crashed (SIGABRT)"),
    "hog": (70, "MemoryError"),
    "exit0": (70, "ended early (exit 0)"),
    "exit7": (70, "ended early (exit 7)"),
    "exit113": (70, "ended early (exit 113)"),
    "quit": (70, "SystemExit: 3"),
    "raise": (70, "ValueError: two lines"),
    "unspeakable": (70, "not JSON serializable"),
    "nothing": (70, "TypeError"),
    "nonsense": (70, "nonsense"),
    "endless": (70, "nonsense"),
    "killed": (5, "was killed"),
}


def test_every_bad_file_costs_itself_alone(impatient: None) -> None:
    items = [item(f"good-{n}", milliseconds=n % 5) for n in range(100)]
    for at, name in enumerate(BAD):
        items.insert(3 + 7 * at, item(f"{name}-"))
    outcomes = {o.path: o for o in run(items)}
    assert len(outcomes) == len(items) == 100 + len(BAD)
    good = [o for o in outcomes.values() if "good-" in o.path]
    assert [o.status for o in good] == ["complete"] * 100
    for name, (exit_code, reason) in BAD.items():
        outcome = outcomes[f"/nowhere/{name}-"]
        assert (outcome.status, outcome.exit_code) == ("failed", exit_code), name
        assert reason in outcome.reason, name
        assert "\n" not in outcome.reason


def test_what_does_not_end_is_stopped_at_the_limit(impatient: None) -> None:
    outcomes = {
        o.path: o for o in run([item("hang-"), item("deaf-"), item("good-")], Settings(time_limit=3.0))
    }
    for name in ("hang-", "deaf-"):
        outcome = outcomes[f"/nowhere/{name}"]
        assert (outcome.status, outcome.exit_code) == ("failed", 5)
        assert "not drawn within 3 s" in outcome.reason
    assert outcomes["/nowhere/good-"].status == "complete"


def test_nothing_but_crashes(tmp_path: Path) -> None:
    outcomes = run([item(f"segfault-{n}", tmp_path) for n in range(12)])
    assert [o.exit_code for o in outcomes] == [70] * 12


def test_a_worker_killed_from_outside_is_replaced_and_its_file_drawn(tmp_path: Path) -> None:
    outcomes = run([item(f"killedonce-{n}", tmp_path) for n in range(5)])
    assert [o.status for o in outcomes] == ["complete"] * 5


def test_damage_that_shows_at_the_next_file_is_not_blamed_on_it() -> None:
    outcomes = run([item("poison-"), item("good-1"), item("good-2")], workers=1)
    assert [(o.path, o.status) for o in outcomes] == [
        ("/nowhere/poison-", "complete"),
        ("/nowhere/good-1", "complete"),
        ("/nowhere/good-2", "complete"),
    ]


def test_what_a_dead_worker_was_writing_is_removed(tmp_path: Path) -> None:
    (tmp_path / ".other.png.0123456789ab.part").touch()
    (outcome,) = run([item("leftover-", tmp_path)])
    assert outcome.exit_code == 70
    assert [p.name for p in tmp_path.iterdir()] == [".other.png.0123456789ab.part"]


def test_no_items_start_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    def start(*_: object, **__: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(fork_server, "_idle", [])
    monkeypatch.setattr(fork_server.subprocess, "Popen", start)
    assert run([]) == []
    with pytest.raises(AssertionError, match="a process was started"):
        run([item("good-")])


def test_an_outcome_is_taken_before_its_worker_gets_more(tmp_path: Path) -> None:
    """So that it can be kept first: whatever ends this process then costs each worker one file."""
    given = 0

    def items() -> Iterator[Item]:
        nonlocal given
        for n in range(12):
            given += 1
            yield item(f"good-{n}")

    outcomes = draw_all(items(), WITHOUT, 2, draw=misbehaving_draw.draw)
    for finished, _ in enumerate(outcomes, 1):
        assert given <= finished + 1  # the other worker's


def test_items_are_taken_as_workers_fall_free() -> None:
    taken = 0

    def endless() -> Iterator[Item]:
        nonlocal taken
        while True:
            taken += 1
            yield item(f"good-{taken}")

    outcomes = draw_all(endless(), WITHOUT, 2, draw=misbehaving_draw.draw)
    for finished in range(1, 20):
        next(outcomes)
        assert taken <= finished + 2 * 2 + 1
    outcomes.close()  # type: ignore[attr-defined]


def test_paths_of_any_bytes_come_back() -> None:
    path = os.fsdecode(b"/nowhere/good-\xff\xfe \"'\n\xc3\xa4")
    (outcome,) = run([Item(path, path + ".png")])
    assert (outcome.path, outcome.target) == (path, path + ".png")


def test_workers_are_renewed_after_so_many_files() -> None:
    def workers(**more: object) -> int:
        return len({o.reason for o in run([item(f"good-{n}") for n in range(12)], workers=1, **more)})

    assert workers(max_files=4) == 3
    assert workers(max_files=None) == 1


def test_a_worker_that_grew_is_renewed() -> None:
    names = ["good-1", "good-2", "good-3", "grow-4", "good-5", "good-6"]
    outcomes = run([item(name) for name in names], workers=1)
    assert [o.status for o in outcomes] == ["complete"] * 6
    assert len({o.reason for o in outcomes[:4]}) == 1
    assert len({o.reason for o in outcomes[4:]} | {outcomes[3].reason}) == 2


def test_workers_that_cannot_start_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "_RETRY_SECONDS", 0.01)
    with pytest.raises(trimray.Error, match="workers do not start: FileNotFoundError"):
        list(draw_all([item("good-")], WITHOUT, 2, draw=misbehaving_draw.Unloadable()))


def test_an_exception_of_the_items_passes_through() -> None:
    def items() -> Iterator[Item]:
        yield item("good-")
        raise LookupError("list")

    with pytest.raises(LookupError, match="list"):
        list(draw_all(items(), WITHOUT, 1, draw=misbehaving_draw.draw))


def test_closing_kills_all_workers_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fork_server, "_idle", [])
    monkeypatch.setattr(fork_server.tempfile, "tempdir", str(tmp_path))
    outcomes = draw_all(
        [item("good-"), item("hang-1"), item("deaf-2")], WITHOUT, 2, draw=misbehaving_draw.draw
    )
    assert next(outcomes).status == "complete"
    assert until(lambda: len(processes(str(tmp_path))) == 3)
    outcomes.close()  # type: ignore[attr-defined]
    assert until(lambda: not processes(str(tmp_path)))
    assert list(tmp_path.iterdir()) == []


def test_the_server_may_be_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fork_server, "_idle", [])
    monkeypatch.setattr(fork_server.tempfile, "tempdir", str(tmp_path))
    items = [item(f"good-{n}", milliseconds=30) for n in range(30)]
    outcomes = draw_all(items, WITHOUT, 2, draw=misbehaving_draw.draw)
    first = next(outcomes)
    for pid in processes(str(tmp_path)):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    rest = list(outcomes)
    assert {o.path for o in [first, *rest]} == {i.path for i in items}
    assert {o.status for o in rest} == {"complete"}


SUPERVISOR = """
import sys, pathlib
from trimray.batch.pool import draw_all
from trimray.batch.record import Item, Settings
import misbehaving_draw
print("main", flush=True)  # there is no guard: were __main__ imported again, this would be said again
names = sys.argv[1:]
items = [Item(name, name + ".png", 100) for name in names]
for outcome in draw_all(items, Settings(time_limit=None), 2, draw=misbehaving_draw.draw):
    print(outcome.status, flush=True)
"""


@contextlib.contextmanager
def supervisor(folder: Path, *names: str) -> Iterator[subprocess.Popen[str]]:
    script = folder / "supervisor.py"
    script.write_text(textwrap.dedent(SUPERVISOR))
    root = str(Path(trimray.__path__[0]).parent)
    env = {**os.environ, "TMPDIR": str(folder), "PYTHONPATH": os.pathsep.join([str(HERE), root])}
    with subprocess.Popen(
        [sys.executable, str(script), *names], stdout=subprocess.PIPE, text=True, env=env, cwd=folder
    ) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_no_process_outlives_the_supervisor(tmp_path: Path, end: signal.Signals) -> None:
    with supervisor(tmp_path, "good-", "reader-1", "deaf-2") as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "main\n"
        assert process.stdout.readline() == "complete\n"
        # The server, two workers and the reader of one.
        assert until(lambda: len(processes(f"{tmp_path}/trimray-batch-")) == 4)
        process.send_signal(end)
        assert until(lambda: not processes(str(tmp_path)))
        assert not list(tmp_path.glob("trimray-batch-*"))


def test_a_script_needs_no_guard_and_leaves_nothing(tmp_path: Path) -> None:
    with supervisor(tmp_path, "good-1", "good-2") as process:
        assert process.communicate()[0] == "main\ncomplete\ncomplete\n"
    assert process.returncode == 0
    assert until(lambda: not processes(str(tmp_path)))
    assert [p.name for p in tmp_path.iterdir() if p.name != "supervisor.py"] == []
