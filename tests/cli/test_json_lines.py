"""--progress json: whatever a command has to say on stderr is a JSON line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from .conftest import Run, process


def events(err: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in err.splitlines()]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("render", "bracket.step", "-o", "OUT/a.png", "--size", "16", "-v"), " faces drawn, "),
        (
            ("turntable", "patch.step", "-o", "OUT/a.webp", "--size", "16", "--frames", "2", "-v"),
            " faces drawn, ",
        ),
        (("mesh", "patch.step", "-o", "OUT/a.stl", "-v"), "triangles"),
        (("check", "missing.step"), "missing.step: No such file"),
        (("roundtrip", "missing.step"), "missing.step: No such file"),
        (("compare", "missing.step", "patch.step"), "missing.step: No such file"),
        (("info", "missing.step"), "missing.step: No such file"),
        (("bench", "missing.step"), "missing.step: No such file"),
        (("render", "bracket.step"), "missing output"),
        (("batch", "missing.step", "-o", "OUT/b", "--gallery", "-vv"), "missing.step: failed: No such file"),
        (("batch", "OUT", "-o", "OUT/b"), "no file found"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else None,
)
def test_every_line_is_an_event(
    run: Run, samples_dir: Path, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    places = [word.replace("OUT", str(tmp_path)) if "OUT" in word else word for word in words]
    places = [str(samples_dir / word) if word.endswith(".step") else word for word in places]
    told = events(run(*places, "--progress", "json").err)
    assert any(said in event.get("text", "") for event in told), told
    assert all(event["event"] == "progress" or event["level"] in ("error", "info") for event in told)


@pytest.mark.parametrize("flag", [("--progress", "json"), ("--progress=json",)])
def test_so_is_wrong_usage(run: Run, flag: tuple[str, ...]) -> None:
    result = run("render", "a.step", "--sise", "3", *flag)
    (event,) = events(result.err)
    assert result.code == 2 and event["level"] == "error" and "--sise" in event["text"]
    assert run("render", "a.step", "--sise", "3").err.startswith("trimray: ")


def test_so_it_is_where_the_environment_asks(samples_dir: Path) -> None:
    result = process("info", samples_dir / "none.step", TRIMRAY_PROGRESS="json")
    assert [event["event"] for event in events(result.err)] == ["message"] and result.code == 3
    result = process("info", samples_dir / "none.step", "--progress", "none", TRIMRAY_PROGRESS="json")
    assert result.err.startswith("trimray: ")
