"""`trimray` as a user runs it: a process of its own, whose descendants can be found wherever they went."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from dataclasses import dataclass, field
from pathlib import Path

_MARK = "TRIMRAY_TORTURE_MARK"
_PICTURES = (".png", ".jpg", ".webp")


@dataclass
class Done:
    code: int
    out: bytes
    err: bytes
    seconds: float
    left: list[str]  # processes
    scratch: list[str]  # files left under TMPDIR


@dataclass
class Command:
    """Starts at once. Stderr goes to a file, since processes that outlive it would hold a pipe open."""

    arguments: list[str]
    environment: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._mark = uuid.uuid4().hex
        self._folder = tempfile.TemporaryDirectory(prefix="torture-")
        home = Path(self._folder.name)
        self.scratch = home / "tmp"
        self.scratch.mkdir()
        self._out, self._err = home / "out", home / "err"
        environment = os.environ | {_MARK: self._mark, "TMPDIR": str(self.scratch)} | self.environment
        self._start = time.monotonic()
        with self._out.open("wb") as out, self._err.open("wb") as err:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "trimray.cli", *self.arguments],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
                env=environment,
                start_new_session=True,
            )

    def wait(self, timeout: float | None = None, grace: float = 60.0) -> Done:
        """grace: seconds in which what it started may end after it. Kills all when the time is over."""
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.kill_all()
            raise
        seconds = time.monotonic() - self._start
        until = time.monotonic() + grace
        while (left := self.processes()) and time.monotonic() < until:
            time.sleep(0.05)
        done = Done(
            self.process.returncode,
            self._out.read_bytes(),
            self._err.read_bytes(),
            seconds,
            list(left.values()),
            [str(p.relative_to(self.scratch)) for p in self.scratch.rglob("*")],
        )
        self.kill_all()
        self._folder.cleanup()
        return done

    def signal_group(self, number: int) -> None:
        """As a terminal does it, or ``kill -9 -- -PGID``."""
        os.killpg(self.process.pid, number)

    def processes(self) -> dict[int, str]:
        """All that came of this command and runs, by number; zombies do not."""
        found = {}
        mark = f"{_MARK}={self._mark}".encode()
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if mark in (folder / "environ").read_bytes().split(b"\0"):
                    words = (folder / "cmdline").read_bytes().split(b"\0")
                    found[int(folder.name)] = b" ".join(words).decode(errors="replace")[:200]
            except OSError:
                continue
        return found

    def kill_all(self) -> None:
        for number in self.processes():
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                continue


def pictures(output: Path) -> dict[bytes, tuple[int, int]]:
    """Pictures in the folder, by path: inode and time, that change when one is written again."""
    found = {}
    for folder, _, names in os.walk(os.fsencode(output)):
        for name in names:
            if name.lower().endswith(tuple(s.encode() for s in _PICTURES)):
                path = os.path.join(folder, name)
                try:
                    about = os.lstat(path)
                except FileNotFoundError:
                    continue
                found[os.path.relpath(path, os.fsencode(output))] = (about.st_ino, about.st_mtime_ns)
    return found


def wait_for_pictures(command: Command, output: Path, count: int, timeout: float = 300) -> int:
    """Until so many pictures are there, or the command has ended; returns their number."""
    until = time.monotonic() + timeout
    while time.monotonic() < until:
        there = len(pictures(output))
        if there >= count or command.process.poll() is not None:
            return there
        time.sleep(0.02)
    raise TimeoutError(f"{len(pictures(output))} of {count} pictures after {timeout:g} s")
