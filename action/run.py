"""The step "Run trimray" of action.yml: chooses the files, runs the command, writes the job's summary.

Inputs come by environment: TRIMRAY_ACTION_COMMAND, _FILES, _OPTIONS, _BASE (what the changes are against) and
_REPORT (folder to be uploaded). Ends with the exit code of the command; 0 where there is no file to look at.
"""

from __future__ import annotations

import glob
import json
import os
import shlex
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

COMMANDS = ("check", "roundtrip")
SUFFIXES = (".step", ".stp", ".stpz", ".igs", ".iges", ".brep")
_ROWS = 200
_LONGEST = 300  # characters of a cell
_ROUGH = frozenset("|<>[]`*_\\\r\n")


def chosen(patterns: str, base: str) -> list[str]:
    """Paths that fit patterns, one a line; without any, the CAD files that were changed since base."""
    lines = [line.strip() for line in patterns.splitlines() if line.strip()]
    if lines:
        found = {path for line in lines for path in glob.glob(line, recursive=True)}
    else:
        found = set(_changed(base))
    return sorted(path for path in found if os.path.isfile(path) and path.lower().endswith(SUFFIXES))


def _changed(base: str) -> list[str]:
    """All tracked files where it is not known what has changed, as in a new branch."""
    if base.strip("0") and not base.startswith("-"):
        _git("fetch", "--quiet", "--depth=1", "origin", base)  # a checkout has one commit only
        found = _git("diff", "--name-only", "--diff-filter=ACMRT", "-z", base, "HEAD", "--")
        if found is not None:
            return found
    return _git("ls-files", "-z") or []


def _git(*arguments: str) -> list[str] | None:
    done = subprocess.run(["git", *arguments], capture_output=True, check=False)
    return [os.fsdecode(path) for path in done.stdout.split(b"\0") if path] if done.returncode == 0 else None


def summary(document: Mapping[str, Any]) -> str:
    """The results of --json as a table in Markdown."""
    lines = ["| file | verdict | differences | first |", "|---|---|---|---|"]
    for result in document["results"][:_ROWS]:
        different = [
            finding for about in result["comparisons"] for finding in about["findings"] if not finding["same"]
        ]
        errors = [result["error"], *(about["error"] for about in result["comparisons"])]
        first = next(filter(None, errors), "") or (_finding(different[0]) if different else "")
        cells = (result["input"], result["verdict"], str(len(different)), first)
        lines.append(f"| {' | '.join(map(_plain, cells))} |")
    left = len(document["results"]) - _ROWS
    return "\n".join([*lines, *([f"\nand {left} more"] if left > 0 else [])]) + "\n"


def _finding(finding: Mapping[str, Any]) -> str:
    return ", ".join(x for x in (finding["name"], finding["where"], finding["reason"]) if x)


def _plain(text: str) -> str:
    """Names in files are anybody's: no markup, and one line."""
    return "".join(
        f"&#{ord(c)};" if c in _ROUGH else c for c in text[:_LONGEST] if c.isprintable() or c in _ROUGH
    )


def _tell(variable: str, text: str) -> None:
    """Appends to one of the files by which a job is told something."""
    path = os.environ.get(variable)
    if path:
        with open(path, "a", encoding="utf-8", errors="replace") as file:
            file.write(text)


def main() -> int:
    inputs = {
        key: os.environ.get(f"TRIMRAY_ACTION_{key}", "") for key in ("COMMAND", "FILES", "OPTIONS", "BASE")
    }
    command = inputs["COMMAND"] or "check"
    if command not in COMMANDS:
        print(f"::error::trimray: command '{_plain(command)}' is not one of {', '.join(COMMANDS)}")
        return 2
    files = chosen(inputs["FILES"], inputs["BASE"])
    _tell("GITHUB_STEP_SUMMARY", f"### trimray {command}\n\n")
    if not files:
        print("trimray: no CAD files to look at")
        _tell("GITHUB_STEP_SUMMARY", "No CAD files to look at.\n")
        _tell("GITHUB_OUTPUT", "exit-code=0\n")
        return 0
    folder = Path(os.environ.get("TRIMRAY_ACTION_REPORT") or "trimray-report")
    folder.mkdir(parents=True, exist_ok=True)
    written, page = folder / "report.json", folder / "report.html"
    words = [command, *shlex.split(inputs["OPTIONS"]), "--progress", "plain", "--html", str(page), "--json"]
    with written.open("wb") as output:
        code = subprocess.run(
            [sys.executable, "-m", "trimray.cli", *words, "--", *files], stdout=output, check=False
        ).returncode
    try:
        text = summary(json.loads(written.read_bytes()))
    except (ValueError, KeyError, TypeError):
        text = f"trimray ended with exit code {code} and no results: see the log.\n"
    _tell("GITHUB_STEP_SUMMARY", text)
    _tell("GITHUB_OUTPUT", f"exit-code={code}\n")
    if code:
        print(f"::error::trimray {command}: exit code {code}; see the summary and the report of this run")
    return code


if __name__ == "__main__":
    sys.exit(main())
