"""Runs the thumbnailer in a process of its own, as file managers do; reads PNG with another library."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from PIL import Image

Thumbnailer = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def thumbnailer() -> Thumbnailer:
    """thumbnailer("-s", 64, path, target): without home, cache and configuration. before: Python that runs
    first."""

    def run(*arguments: object, before: str = "", **environment: str) -> subprocess.CompletedProcess[str]:
        kept = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH")
        code = f"import sys\n{before}\nfrom trimray.desktop.thumbnail import main\nsys.exit(main())"
        return subprocess.run(
            [
                sys.executable,
                "-c",
                code,
                *(os.fsdecode(a) if isinstance(a, bytes) else str(a) for a in arguments),
            ],
            capture_output=True,
            text=True,
            errors="surrogateescape",
            env={name: os.environ[name] for name in kept if name in os.environ} | environment,
            timeout=300,
            check=False,
        )

    return run


def opened(path: Path) -> Image.Image:
    """With all its chunks read."""
    image = Image.open(path)
    image.load()
    return image
