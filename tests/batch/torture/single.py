"""What `trimray render` alone says of one file: the judge of the batch."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from .judge import pixels_of


@dataclass(frozen=True)
class Single:
    code: int
    error: str
    pixels: bytes


def render(path: str | Path, folder: Path, size: tuple[int, int], *more: str) -> Single:
    """folder: for the picture, which is removed."""
    picture = folder / "single.png"
    done = subprocess.run(
        [
            *(sys.executable, "-m", "trimray.cli", "render", "-o", str(picture), "--no-cache"),
            *("--size", f"{size[0]},{size[1]}", *more, "--", str(path)),
        ],
        capture_output=True,
        check=False,
    )
    pixels = b""
    if picture.exists():
        pixels = pixels_of(picture).tobytes()
        picture.unlink()
    return Single(done.returncode, done.stderr.decode(errors="replace"), pixels)


def status_of(single: Single) -> str:
    """In the words of a batch, where a single picture tells."""
    return {0: "complete", 1: "partial"}.get(single.code, "failed")
