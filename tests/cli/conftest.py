"""Runs the command in this process, and in one of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cadquery as cq
import pytest

from trimray.cli.__main__ import main

Run = Callable[..., "Result"]


@dataclass
class Result:
    code: int
    out: bytes
    err: str


@pytest.fixture
def run(capfdbinary: pytest.CaptureFixture[bytes]) -> Run:
    """run("render", path, ...): exit code, stdout, stderr."""

    def call(*arguments: object) -> Result:
        capfdbinary.readouterr()
        code = main([str(a) for a in arguments])
        sys.stdout.flush()
        sys.stderr.flush()
        captured = capfdbinary.readouterr()
        return Result(code, captured.out, captured.err.decode())

    return call


def process(*arguments: object, input: bytes = b"", **environment: str) -> Result:
    """The same in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "trimray.cli", *(str(a) for a in arguments)],
        input=input,
        capture_output=True,
        env=os.environ | environment,
        check=False,
    )
    return Result(done.returncode, done.stdout, done.stderr.decode())


def one_line(err: str) -> bool:
    return err.startswith("trimray: ") and err.count("\n") == 1


def interrupted(*arguments: object, stage: str) -> tuple[int, str]:
    """Of a process that gets SIGINT once it says that it is in that stage: exit code, and what it says then.
    It must take long enough to be still at it; one that goes on is killed after a minute or two."""
    command = [sys.executable, "-m", "trimray.cli", *(str(a) for a in arguments), "--progress", "plain"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as child:
        assert child.stderr is not None
        try:
            assert any(f": {stage}" in line for line in child.stderr), "it ended before that stage"
            child.send_signal(signal.SIGINT)
            err = child.communicate(timeout=120)[1]
        finally:
            child.kill()
    return child.returncode, "\n".join(x for x in err.split("\n") if x and f": {stage}" not in x)


@pytest.fixture(scope="session")
def box_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("models") / "box.step"
    cq.exporters.export(cq.Workplane().box(10, 20, 30), str(path))
    return path


@pytest.fixture(scope="session")
def ball_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("models") / "ball.step"
    cq.exporters.export(cq.Workplane().sphere(10), str(path))
    return path
