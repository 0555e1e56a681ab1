"""--time-limit of check, roundtrip and compare is one of everything: reading, writing, comparing."""

from __future__ import annotations

import json
import signal
import time
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Any

import pytest

import trimray
from trimray.cli.limit import within

from .conftest import Run


def forever(*_: Any, progress: Any = None, **__: Any) -> None:
    """Its limit is over as soon as it has said where it is, and not before: when that is on the clock depends
    on the machine."""
    if progress is not None:
        progress("geometry", None)
    assert signal.getitimer(signal.ITIMER_REAL)[0] > 0
    signal.raise_signal(signal.SIGALRM)
    time.sleep(600)


def nothing(stage: str, fraction: float | None) -> None:
    pass


@pytest.mark.parametrize(
    ("work", "words"),
    [
        ("trimray.fidelity.check.check", ("check", "a.step")),
        ("trimray.fidelity.roundtrip.roundtrip", ("roundtrip", "a.step", "--keep", "kept.step")),
        ("trimray.fidelity.compare", ("compare", "a.step", "b.step")),
    ],
)
def test_a_comparison_ends_at_the_limit(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, work: str, words: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work, forever)
    monkeypatch.setattr("trimray.fidelity.read", lambda *_, **__: trimray.fidelity.Side("a", None))
    result = run(*words, "--time-limit", "500", "--json", "--junit", "r.xml")
    name = " - ".join(word for word in words if word in ("a.step", "b.step"))
    line = f"{name}: not done within 500 s (stopped in stage 'geometry')"
    assert (result.code, result.err) == (5, f"trimray: {line}\n")
    (about,) = json.loads(result.out)["results"]
    assert (about["verdict"], about["error"], about["exit_code"]) == ("failed", line, 5)
    (error,) = xml.parse("r.xml").getroot().iter("error")
    assert error.get("message") == line
    assert [path.name for path in tmp_path.iterdir()] == ["r.xml"]


def test_the_next_input_has_a_limit_of_its_own(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []

    def check(source: str, **_: Any) -> None:
        done.append(source)
        forever()

    monkeypatch.setattr("trimray.fidelity.check.check", check)
    result = run("check", "one.step", "two.step", "--time-limit", "500")
    assert result.code == 5 and done == ["one.step", "two.step"]
    assert result.err.count("not done within 500 s") == 2


def test_the_limit_is_over_with_the_work() -> None:
    before = signal.getsignal(signal.SIGALRM)
    with within(100.0, "a", nothing) as limited:
        assert 0.0 < (limited.left() or 0.0) <= 100.0
        assert signal.getsignal(signal.SIGALRM) is not before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) is before


def test_without_a_limit_nothing_is_watched() -> None:
    with within(None, "a", nothing) as limited:
        assert limited.left() is None and signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_the_clock_ends_work() -> None:
    with pytest.raises(trimray.TimeLimitError, match="a: not done within"), within(0.05, "a", nothing):
        time.sleep(600)


def test_work_that_does_not_listen_is_told_again() -> None:
    """As where somebody's code catches every exception."""
    deaf = 0
    with pytest.raises(trimray.TimeLimitError, match="a: not done within"), within(500.0, "a", nothing):
        assert signal.getitimer(signal.ITIMER_REAL)[1] > 0
        try:
            forever()
        except trimray.TimeLimitError:
            deaf += 1
        forever()
    assert deaf == 1


def test_a_clock_that_rings_while_the_work_is_cleared_away_does_no_harm(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before, setitimer = signal.getsignal(signal.SIGALRM), signal.setitimer
    with within(500.0, "a", nothing):
        monkeypatch.setattr(
            signal, "setitimer", lambda *words: (signal.raise_signal(signal.SIGALRM), setitimer(*words))
        )
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_reading_within_the_limit_changes_nothing(run: Run, box_file: Path) -> None:
    result = run("compare", box_file, box_file, "--no-pictures", "--time-limit", "300")
    assert (result.code, result.err) == (0, "")
