"""The manual is current, and what the README shows works."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from trimray.cli import manual
from trimray.cli.options import OPTIONS

from .conftest import Run

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
MANUAL = (ROOT / "docs" / "cli.md").read_text()


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.M | re.S)


def test_the_table_of_options_is_current() -> None:
    """Otherwise: python -m trimray.cli.manual table"""
    _, _, rest = MANUAL.partition("manual table -->\n")
    assert rest.partition("<!-- /options -->")[0] == manual.options_table()
    for option in OPTIONS:
        assert all(flag in rest for flag in option.flags)


def test_the_exit_codes_are_current() -> None:
    for code, meaning in manual.EXIT_CODES:
        assert f"| {code} | {meaning} |" in MANUAL


def test_the_manual_page_is_current() -> None:
    """Otherwise: python -m trimray.cli.manual man > docs/trimray.1"""
    assert (ROOT / "docs" / "trimray.1").read_text() == manual.man_page()


@pytest.mark.skipif(shutil.which("man") is None, reason="no man on this machine")
def test_the_manual_page_has_no_errors() -> None:
    command = ["man", "--warnings=all", "-l", str(ROOT / "docs" / "trimray.1")]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        env=os.environ | {"MANPAGER": "cat", "MANWIDTH": "80"},
        check=True,
    )
    assert done.stderr == "" and "--background" in done.stdout


def test_every_key_of_the_json_is_explained(run: Run, samples_dir: Path, tmp_path: Path) -> None:
    def keys(value: object) -> set[str]:
        if isinstance(value, list):
            return set().union(*(keys(x) for x in value))
        if not isinstance(value, dict):
            return set()
        # The keys of these two are data.
        return set(value).union(*(keys(v) for k, v in value.items() if k not in ("faces_by_kind", "seconds")))

    facts = json.loads(run("info", samples_dir / "assembly.step", tmp_path / "missing.step", "--json").out)
    picture = ("-o", tmp_path / "a.png", "--size", "8", "--report", "-")
    report = json.loads(run("render", samples_dir / "assembly.step", *picture).out)
    assert report["results"][0]["report"]["seconds"].keys() >= {"cache", "hierarchy", "trace"}
    for key in keys(facts) | keys(report) | report["results"][0]["report"]["seconds"].keys():
        assert f"`{key}`" in MANUAL, key


def test_every_key_of_a_batch_is_explained(run: Run, samples_dir: Path, tmp_path: Path) -> None:
    words = ("-o", tmp_path, "--size", "8", "--report", "-", "--progress", "json")
    result = run("batch", samples_dir / "patch.step", *words)
    event = next(line for line in result.err.splitlines() if line.startswith("{"))
    keys = json.loads(result.out).keys() | json.loads(event).keys()
    assert {"status", "files_per_second"} <= keys
    for key in keys:
        assert f"`{key}`" in MANUAL, key


@pytest.fixture
def workplace(tmp_path: Path, samples_dir: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that looks like the checkout to the commands of the README."""
    (tmp_path / "samples").symlink_to(samples_dir)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_commands_of_the_readme_work(run: Run, workplace: Path) -> None:
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("trimray ")]
    assert len(lines) >= 5
    for line in lines:
        words = shlex.split(line, comments=True)[1:]
        result = run(*words)
        assert result.code == 0 and result.err == "", (line, result.err)
        if "-o" in words:
            written = workplace / words[words.index("-o") + 1]
            files = [*written.rglob("*.png")] if written.is_dir() else [written]
            assert files and all(
                file.stat().st_size > (100 if written.is_dir() else 1000) for file in files
            ), line


def test_the_options_that_the_readme_names_exist() -> None:
    known = {part for option in OPTIONS for flag in option.flags for part in flag.split("/")}
    assert set(re.findall(r"`(--[a-z-]+)`", README)) <= known


def test_the_python_of_the_readme_works(workplace: Path) -> None:
    """In one process, one block after the other, as a reader would type them."""
    code = "\n".join(blocks("python"))
    assert "trimray.load" in code and "model.cast" in code
    checks = (
        "\nassert depth.shape == (768, 1024) and str(depth.dtype) == 'float64'"
        "\nassert hits.t.shape == (2,) and hits.normal.shape == (2, 3)"
    )
    done = subprocess.run([sys.executable, "-c", code + checks], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (workplace / "bracket.png").read_bytes().startswith(b"\x89PNG")
