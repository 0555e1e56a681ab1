"""Batches on the library: undisturbed, killed and resumed, interrupted and resumed."""

from __future__ import annotations

import os
import random
import signal
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from .command import Command, Done, pictures, wait_for_pictures
from .entry import Entry
from .judge import Row, differences, judge_end, rows_of, unnamed, unsettled
from .single import render, status_of

SIZE = (96, 96)


@dataclass(frozen=True)
class Setup:
    """folder: for all that is made. limits: the words of --time-limit and --memory-limit."""

    library: Path
    folder: Path
    entries: list[Entry]
    workers: int = 2
    limits: tuple[str, str] = ("60", "1G")

    @property
    def limit_words(self) -> list[str]:
        return ["--time-limit", self.limits[0], "--memory-limit", self.limits[1]]

    def start(self, name: str, *more: str) -> Command:
        """A batch into folder/name, with its report in folder/name.jsonl."""
        words = ["batch", str(self.library), "-o", str(self.output(name)), "-j", str(self.workers)]
        words += ["--size", f"{SIZE[0]},{SIZE[1]}", *self.limit_words, "--report", str(self.report(name))]
        return Command([*words, *more])

    def output(self, name: str) -> Path:
        return self.folder / name

    def report(self, name: str) -> Path:
        return self.folder / f"{name}.jsonl"

    def rows(self, name: str) -> dict[bytes, Row]:
        return rows_of(self.report(name), self.library)


def undisturbed(setup: Setup, name: str, timeout: float) -> tuple[Done, list[str]]:
    done = setup.start(name).wait(timeout)
    return done, judge_end(done) + unnamed(setup.rows(name), done.err)


def disturbed(
    setup: Setup, name: str, like: str, how: str, share: float, timeout: float
) -> tuple[list[str], int]:
    """A run that ends by ``how`` when ``share`` of the pictures of the run ``like`` are there, then --resume.

    how: "group" (kill -9 of the process group), "supervisor" (of the first process), "SIGINT" (Ctrl-C),
    "SIGTERM". Returns what is wrong, and how many pictures were made twice.
    """
    output = setup.output(name)
    before = pictures(setup.output(like))
    command = setup.start(name)
    problems = []
    wait_for_pictures(command, output, int(share * len(before)), timeout)
    if command.process.poll() is not None:
        command.wait()
        return ["the run ended before it could be disturbed"], 0
    {
        "group": lambda: command.signal_group(signal.SIGKILL),
        "supervisor": lambda: os.kill(command.process.pid, signal.SIGKILL),
        "SIGINT": lambda: command.signal_group(signal.SIGINT),
        "SIGTERM": lambda: os.kill(command.process.pid, signal.SIGTERM),
    }[how]()
    killed = command.wait(240)
    problems += judge_end(killed, 130 if how in ("SIGINT", "SIGTERM") else -signal.SIGKILL)
    there = pictures(output)
    problems += [f"half a picture: {path!r}" for path in there if not _is_whole(output, path)]

    done = setup.start(name, "--resume").wait(timeout)
    problems += judge_end(done)
    after = pictures(output)
    again = [path for path, mark in there.items() if after.get(path) != mark]
    if len(again) > setup.workers:
        problems.append(
            f"{len(again)} finished pictures were made again by {setup.workers} workers: {again[:5]}"
        )
    return problems + unlike(setup, like, name), len(again)


def unlike(setup: Setup, first: str, second: str) -> list[str]:
    """In what two runs differ: rows, and bytes of pictures."""
    rows = setup.rows(first), setup.rows(second)
    found = differences(unplaced(rows[0]), unplaced(rows[1]))
    skip: set[bytes] = set()
    for name, some in zip((first, second), rows, strict=True):
        for path in unsettled(*rows):
            if some[path]["output"]:
                skip.add(os.path.relpath(os.fsencode(some[path]["output"]), os.fsencode(setup.output(name))))
    return found + different_pictures(setup.output(first), setup.output(second), skip)


def different_pictures(first: Path, second: Path, skip: set[bytes]) -> list[str]:
    """Byte by byte. skip: paths in both folders."""
    found = []
    a, b = pictures(first), pictures(second)
    found += [f"{path!r} is in one folder only" for path in sorted((a.keys() ^ b.keys()) - skip)]
    for path in sorted((a.keys() & b.keys()) - skip):
        if _bytes(first, path) != _bytes(second, path):
            found.append(f"{path!r} has other bytes")
    return found


def singles(entries: list[Entry], library: Path, folder: Path) -> dict[str, tuple[str, bytes]]:
    """For each model, what `trimray render` makes of it."""
    found: dict[str, tuple[str, bytes]] = {}
    for entry in entries:
        if entry.alias and entry.path.startswith(b"good/"):
            single = render(library / entry.shown, folder, SIZE)
            found[entry.alias] = (status_of(single), single.pixels)
    return found


def unlike_singles(setup: Setup, rows: Mapping[bytes, Row], count: int, seed: int) -> tuple[list[str], int]:
    """A sample of files of which nothing is known, against a `trimray render` of each, with the same limits.

    Returns the differences, and how many were looked at.
    """
    unknown = [entry for entry in setup.entries if entry.expect == "either" and not entry.alias]
    sample = random.Random(seed).sample(unknown, min(count, len(unknown)))
    problems = []
    for entry in sample:
        row = rows[entry.path]
        single = render(setup.library / entry.shown, setup.folder, SIZE, *setup.limit_words)
        status = status_of(single)
        told = f"{entry.shown!r}: {row['status']} {row['reason']!r}, alone: {single.code} {single.error!r}"
        if row["status"] == "degraded":
            if single.code != 5:
                problems.append(told)
        elif row["status"] == "blank":
            if status == "failed":
                problems.append(told)
        elif (row["status"], row["exit_code"]) != (status, single.code):
            problems.append(told)
    return problems, len(sample)


def unplaced(rows: Mapping[bytes, Row]) -> dict[bytes, Row]:
    """Without the folder of the pictures, and without what differs each time files of /proc are looked at."""
    found = {}
    for path, row in rows.items():
        drop = {"output", "input"} | ({"sha256", "mtime_ns"} if path.startswith(b"devices/") else set())
        found[path] = {key: value for key, value in row.items() if key not in drop}
    return found


def _bytes(folder: Path, path: bytes) -> bytes:
    with open(os.path.join(os.fsencode(folder), path), "rb") as file:
        return file.read()


def _is_whole(folder: Path, path: bytes) -> bool:
    """A PNG file ends with its last chunk."""
    return _bytes(folder, path).endswith(b"IEND\xaeB`\x82")
