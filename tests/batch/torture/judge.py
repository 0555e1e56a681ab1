"""Holds what a batch left behind against what the library is known to hold."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from .command import Done
from .entry import Entry

Row = Mapping[str, Any]
STATUSES = ("complete", "partial", "degraded", "blank", "failed")
_STATE = re.compile(rb"trimray-batch(\.\d+-of-\d+)?\.sqlite(-wal|-shm)?")
# What may differ between two runs of the same batch.
_OF_THE_RUN = ("seconds", "peak_memory", "attempt", "finished")


@dataclass
class Verdict:
    """problems: one line each; table: kind of file to counts of statuses."""

    problems: list[str] = field(default_factory=list)
    table: dict[str, Counter[str]] = field(default_factory=dict)

    def say(self, entry: Entry | None, text: str) -> None:
        self.problems.append(f"{entry.shown!r} ({entry.kind}): {text}" if entry else text)
        if entry:
            self.table.setdefault(entry.kind, Counter())["unexpected"] += 1


def rows_of(report: Path, library: Path) -> dict[bytes, Row]:
    """The lines of --report by path below the library."""
    rows = {}
    for line in report.read_bytes().decode("utf-8", "surrogateescape").splitlines():
        row = json.loads(line)
        path = os.path.relpath(os.fsencode(row["input"]), os.fsencode(library))
        if path in rows:
            raise AssertionError(f"two lines of the report are about {path!r}")
        rows[path] = row
    return rows


def judge(
    entries: list[Entry],
    rows: Mapping[bytes, Row],
    output: Path,
    size: tuple[int, int],
    *,
    like: Mapping[str, tuple[str, bytes]] | None = None,
) -> Verdict:
    """like: by model, the status and the pixels of a single `trimray render`."""
    verdict = Verdict()
    wanted = {entry.path: entry for entry in entries if entry.expect != "absent"}
    for path in rows.keys() - wanted.keys():
        verdict.say(None, f"{path!r} is no input, but was taken for one")
    for path, entry in wanted.items():
        row = rows.get(path)
        if row is None:
            verdict.say(entry, "is not in the report")
            continue
        counts = verdict.table.setdefault(entry.kind, Counter())
        counts["files"] += 1
        counts[row["status"]] += 1
        for problem in _row(entry, row):
            verdict.say(entry, f"{problem}: {row['status']} {row['exit_code']} {row['reason']!r}")
        known = (like or {}).get(entry.alias)
        if known is not None and known[0] != row["status"]:
            verdict.say(entry, f"{row['status']}, but `trimray render` says {known[0]}")
        if row["status"] != "failed":
            for problem in _picture(row, size, known):
                verdict.say(entry, problem)
        elif row["output"] is not None:
            verdict.say(entry, "failed, but the report names a picture")
    for problem in _folder(rows, output):
        verdict.say(None, problem)
    return verdict


def _row(entry: Entry, row: Row) -> list[str]:
    problems = []
    status, reason, code = row["status"], row["reason"], row["exit_code"]
    if status not in STATUSES:
        problems.append("unknown status")
    if entry.expect == "good" and status not in ("complete", "partial"):
        problems.append("a good model was not drawn")
    if entry.expect == "bad" and status != "failed":
        problems.append("a bad file did not fail")
    if bool(reason) == (status == "complete"):
        problems.append("a reason, and only one, for all that is not complete")
    if "\n" in reason or "Traceback" in reason or "internal error" in reason:
        problems.append("the reason is not one clear line")
    if entry.reason and not re.search(entry.reason, reason):
        problems.append(f"the reason does not match {entry.reason!r}")
    fits = {"complete": (0,), "failed": (3, 4, 5)}.get(status, (1,))
    if code not in fits:
        problems.append("exit code")
    if status == "complete" and (row["not_drawn"] or not row["drawn"]):
        problems.append("complete, but not all faces are drawn")
    return problems


def _picture(row: Row, size: tuple[int, int], like: tuple[str, bytes] | None) -> list[str]:
    try:
        pixels = pixels_of(os.fsencode(row["output"]))
    except (OSError, TypeError, ValueError, SyntaxError) as error:
        return [f"no picture: {error}"]
    if pixels.shape[:2] != (size[1], size[0]):
        return [f"wrong size {pixels.shape}"]
    problems = []
    marked = int((pixels[..., :3] != pixels[0, 0, :3]).any(axis=-1).sum())
    if marked == 0 and row["status"] != "blank" and row["covered"] < 0.99:
        problems.append(f"the picture is blank, which the status {row['status']} does not tell")
    if like is not None and like[1] != pixels.tobytes():
        problems.append("is not the picture that `trimray render` makes")
    return problems


def pixels_of(path: bytes | Path) -> np.ndarray:
    with open(path, "rb") as file, Image.open(file) as image:
        return np.asarray(image.convert("RGBA"))


def _folder(rows: Mapping[bytes, Row], output: Path) -> list[str]:
    """Nothing but pictures and the state."""
    targets = {os.fsencode(row["output"]) for row in rows.values() if row["output"] is not None}
    problems = []
    for folder, _, names in os.walk(os.fsencode(output)):
        for name in names:
            if os.path.join(folder, name) not in targets and not _STATE.fullmatch(name):
                problems.append(f"left in the output: {os.path.join(folder, name)!r}")
    return problems


def judge_end(done: Done, code: int = 1) -> list[str]:
    """What every run must be like, however it was called."""
    problems = []
    if done.code != code:
        problems.append(f"exit code {done.code}, not {code}: {done.err[-500:]!r}")
    if done.out:
        problems.append(f"on stdout: {done.out[:200]!r}")
    if b"Traceback" in done.err:
        problems.append(f"a traceback: {done.err[-1500:].decode(errors='replace')}")
    if done.left:
        problems.append(f"processes left: {done.left}")
    if done.scratch and done.code >= 0:
        problems.append(f"temporary files left: {done.scratch[:5]}")
    return problems


def out_of_time(rows: Mapping[bytes, Row]) -> set[bytes]:
    """Files whose fate hangs on how fast the machine was at that moment."""
    return {
        path
        for path, row in rows.items()
        if "for want of time" in row["reason"] or (row["exit_code"] == 5 and "MiB" not in row["reason"])
    }


def unnamed(rows: Mapping[bytes, Row], err: bytes) -> list[str]:
    """Failures that stderr does not tell of with their reasons."""
    text = err.decode(errors="surrogateescape")
    missing = (row for row in rows.values() if row["status"] == "failed" and row["reason"] not in text)
    return [f"{row['input']!r}: stderr does not give its reason: {row['reason']!r}" for row in missing]


def unsettled(first: Mapping[bytes, Row], second: Mapping[bytes, Row]) -> set[bytes]:
    """Files that ran out of time in either run, and those on which OpenCascade crashed in one alone: on
    damaged files it uses memory that nobody has set."""
    alone = {
        path
        for path in first.keys() & second.keys()
        if first[path]["status"] != second[path]["status"]
        and any("crashed on it" in run[path]["reason"] for run in (first, second))
    }
    return out_of_time(first) | out_of_time(second) | alone


def differences(first: Mapping[bytes, Row], second: Mapping[bytes, Row]) -> list[str]:
    """Rows that are not alike but for time, memory and attempt; unsettled ones aside."""
    found = []
    for path in sorted((first.keys() | second.keys()) - unsettled(first, second)):
        a, b = first.get(path), second.get(path)
        if a is None or b is None:
            found.append(f"{path!r} is in one run only")
            continue
        # Where, and even whether, OpenCascade crashes on a file that fails varies from process to process.
        crashed = any(row["status"] == "failed" and "crashed on it" in row["reason"] for row in (a, b))
        for key in a.keys() | b.keys():
            if key not in _OF_THE_RUN and a.get(key) != b.get(key) and not (crashed and key == "reason"):
                found.append(f"{path!r}: {key} {a.get(key)!r} != {b.get(key)!r}")
    return found


def table(verdict: Verdict) -> str:
    """In Markdown, a line a kind of file."""
    heads = ("files", *STATUSES, "unexpected")
    lines = ["| kind | " + " | ".join(heads) + " |", "|---|" + "---:|" * len(heads)]
    total: Counter[str] = Counter()
    for kind in sorted(verdict.table):
        counts = verdict.table[kind]
        total.update(counts)
        lines.append(f"| {kind} | " + " | ".join(str(counts[head]) for head in heads) + " |")
    lines.append("| all | " + " | ".join(str(total[head]) for head in heads) + " |")
    return "\n".join(lines)
