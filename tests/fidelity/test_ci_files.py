"""The GitHub Action and the pre-commit hook."""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from trimray.cli.options import OPTIONS

ROOT = Path(__file__).resolve().parents[2]
ZERO = "0" * 40  # what GitHub says for a new branch


def parsed(name: str) -> Any:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    return yaml.safe_load((ROOT / name).read_text())


@pytest.fixture(scope="module")
def action() -> ModuleType:
    """action/run.py, which is in no package."""
    spec = importlib.util.spec_from_file_location("trimray_action", ROOT / "action" / "run.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def commands() -> set[str]:
    return {command for option in OPTIONS for command in option.commands}


def test_the_hook_runs_a_command_that_exists() -> None:
    (hook,) = parsed(".pre-commit-hooks.yaml")
    words = hook["entry"].split()
    flags = {flag for option in OPTIONS for flag in option.flags}
    assert words[:2] == ["trimray", "check"] and words[1] in commands() and words[2] in flags
    assert hook["language"] == "system" and hook["id"] == "trimray-check"
    files = re.compile(hook["files"])
    assert all(files.search(name) for name in ("a.step", "b/C.STP", "a.stpZ", "a.igs", "a.iges"))
    assert not any(files.search(name) for name in ("a.step.txt", "step", "a.stl", "igs.py"))


def test_the_action_names_what_exists(action: ModuleType) -> None:
    about = parsed("action.yml")
    steps = about["runs"]["steps"]
    assert about["runs"]["using"] == "composite"
    assert all("shell" in step for step in steps if "run" in step)
    run = next(step for step in steps if step.get("id") == "run")
    assert set(re.findall(r"inputs\.([\w-]+)", json.dumps(steps))) == set(about["inputs"])
    assert {f"TRIMRAY_ACTION_{word}" for word in ("COMMAND", "FILES", "OPTIONS", "BASE", "REPORT")} == set(
        run["env"]
    )
    # What a workflow says reaches a shell as the value of a variable alone.
    assert not any("${{" in step.get("run", "") for step in steps)
    assert (ROOT / "action" / "run.py").is_file() and "/action/run.py" in run["run"]
    assert set(action.COMMANDS) <= commands()


def git(*words: str) -> str:
    identity = ("-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false")
    return subprocess.run(
        ["git", *identity, *words], check=True, capture_output=True, text=True
    ).stdout.strip()


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, samples_dir: Path) -> Path:
    """One commit with a model in it, and a second one with another, and what is no model."""
    monkeypatch.chdir(tmp_path)
    for name in ("COMMAND", "FILES", "OPTIONS", "BASE"):
        monkeypatch.delenv(f"TRIMRAY_ACTION_{name}", raising=False)
    monkeypatch.setenv("TRIMRAY_ACTION_REPORT", str(tmp_path / "report"))
    for name in ("OUTPUT", "STEP_SUMMARY"):
        monkeypatch.setenv(f"GITHUB_{name}", str(tmp_path / name))
    git("init", "-q", ".")
    shutil.copy(samples_dir / "patch.step", "old.step")
    git("add", "old.step")
    git("commit", "-qm", "a")
    (tmp_path / "parts").mkdir()
    shutil.copy(samples_dir / "patch.step", "parts/new [1].STEP")
    (tmp_path / "notes.txt").write_text("")
    git("add", "parts", "notes.txt")
    git("commit", "-qm", "b")
    return tmp_path


def test_changed_files_are_chosen(action: ModuleType, repository: Path) -> None:
    assert action.chosen("", git("rev-parse", "HEAD~1")) == ["parts/new [1].STEP"]
    for unknown in ("", ZERO, "1234" * 10, "--output=x"):
        assert action.chosen("", unknown) == ["old.step", "parts/new [1].STEP"]
    assert action.chosen("", "HEAD") == []
    assert action.chosen("**/*.STEP\n  *.txt\n", "") == ["parts/new [1].STEP"]
    assert not (repository / "x").exists()


def test_the_job_gets_a_summary_and_a_report(
    action: ModuleType, repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (repository / "broken.step").write_text("ISO-10303-21;\n")
    monkeypatch.setenv("TRIMRAY_ACTION_FILES", "*.step")
    code = action.main()
    assert code != 0
    summary = (repository / "STEP_SUMMARY").read_text()
    assert "| old.step | " in summary and "| broken.step | failed | 0 | broken.step: " in summary
    assert (repository / "OUTPUT").read_text() == f"exit-code={code}\n"
    document = json.loads((repository / "report" / "report.json").read_text())
    assert [result["input"] for result in document["results"]] == ["broken.step", "old.step"]
    assert (repository / "report" / "report.html").stat().st_size > 1000


def test_nothing_to_look_at_is_no_failure(
    action: ModuleType, repository: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("TRIMRAY_ACTION_FILES", "*.stl")
    assert action.main() == 0 and "No CAD files" in (repository / "STEP_SUMMARY").read_text()
    monkeypatch.setenv("TRIMRAY_ACTION_COMMAND", "render")
    assert action.main() == 2 and "::error::" in capfd.readouterr().out


def test_names_of_models_are_no_markup(action: ModuleType) -> None:
    nasty = "a|b`<img src=x>`\n[x](http://x)"
    about = {"error": "", "findings": [{"same": False, "name": nasty, "where": "", "reason": ""}]}
    text = action.summary(
        {"results": [{"input": nasty, "verdict": "changed", "error": "", "comparisons": [about]}]}
    )
    row = text.splitlines()[2]
    assert len(text.splitlines()) == 3 and row.count("|") == 5
    assert not set(row) & set("<>[]`")
    long = {"input": "|" * 5000, "verdict": "failed", "error": "|" * 5000, "comparisons": []}
    assert len(action.summary({"results": [long] * 500})) < 1 << 20  # GitHub takes no more
