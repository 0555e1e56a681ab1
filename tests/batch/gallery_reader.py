"""What the tests of the gallery share: files with pictures, and the page as its reader sees it."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from tests.pages import Reader
from trimray.batch.record import Outcome, Status


def png(color: tuple[int, int, int], size: int = 64) -> bytes:
    """A white picture with a square of that colour in its middle."""
    pixels = np.full((size, size, 3), 255, np.uint8)
    pixels[size // 4 : -size // 4, size // 4 : -size // 4] = color
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    data = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + data


def make(
    folder: Path,
    name: str,
    status: Status = "complete",
    color: tuple[int, int, int] = (40, 90, 160),
    **facts: Any,
) -> Outcome:
    """An outcome, and its picture unless it failed."""
    target = folder / "pictures" / f"{name}.png"
    if status != "failed":
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(png(color))
    return Outcome(f"{folder}/in/{name}", str(target), status, **facts)


def library(folder: Path) -> list[Outcome]:
    """Thirty files; faces are 10, 20, ... 300."""
    statuses: dict[int, tuple[Status, str]] = {
        4: ("partial", "1 face not drawn: #12: open loop"),
        9: ("degraded", "read without healing for want of time"),
        14: ("blank", "nothing to be seen"),
    }
    outcomes = []
    for i in range(30):
        status, reason = statuses.get(i, ("complete", ""))
        facts = {"drawn": 10 * (i + 1) - (i == 4), "not_drawn": int(i == 4), "seconds": (i * 7 % 30) / 10}
        more = {"peak_memory": (i * 11 % 30 + 1) << 20, "sha256": f"{i:064x}", "covered": 0.5}
        outcomes.append(make(folder, f"part {i + 1}.step", status, reason=reason, **facts, **more))
    outcomes.append(
        make(folder, "bad/broken.step", "failed", reason="the reader crashed (SIGSEGV)", exit_code=3)
    )
    outcomes.append(
        make(folder, "bad/slow.step", "failed", reason="time limit of 30 s", exit_code=5, seconds=30.0)
    )
    return outcomes


# Of all pictures, once they are there.
WIDTHS = (
    "Promise.all([...document.querySelectorAll('.tile img')]"
    ".map(image => image.decode().then(() => image.naturalWidth)))"
)


class GalleryReader(Reader):
    """A gallery."""

    @property
    def names(self) -> list[str]:
        names: list[str] = self.page.locator(".tile .name").all_text_contents()
        return names

    @property
    def count(self) -> str:
        return str(self.page.locator("#count").text_content())

    @property
    def open(self) -> bool:
        return bool(self.page.locator("#detail").evaluate("dialog => dialog.open"))

    def active(self) -> str:
        return str(self.page.locator(".tile.active .name").text_content())
