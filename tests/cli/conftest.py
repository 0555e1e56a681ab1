"""Runs the command in this process, and in one of its own."""

from __future__ import annotations

import os
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
