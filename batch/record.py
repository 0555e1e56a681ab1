"""What a batch hands from stage to stage: settings, items, outcomes. Plain, picklable, without imports."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Literal

# complete: every face of the file is in the picture. partial: some faces could not be drawn, or the file is
# damaged. degraded: a coarser or unrepaired picture, for want of time. blank: drawn, but (nearly) nothing is
# to be seen. failed: no picture.
Status = Literal["complete", "partial", "degraded", "blank", "failed"]
STATUSES: tuple[Status, ...] = ("complete", "partial", "degraded", "blank", "failed")


@dataclass(frozen=True)
class Settings:
    """How every picture of a batch is made; the words of ``load`` and ``Model.render``.

    size: (width, height), px. format: of ``trimray.formats``. time_limit: seconds for one file, from opening
    it to its picture. memory_limit: bytes, of the process that reads or draws one file; None: no limit.
    cache: use and fill the cache of imported models.
    """

    size: tuple[int, int] = (256, 256)
    view: str = "iso"
    projection: str = "orthographic"
    up: str = "z"
    samples: int = 4
    background: str = "white"
    format: str = "png"
    heal: str = "default"
    precision: float | None = None
    time_limit: float | None = 30.0
    memory_limit: int | None = 2 << 30
    cache: bool = False

    def key(self) -> str:
        """The same text for the same pictures, limits included, since a failure may depend on them."""
        words: dict[str, Any] = asdict(self)
        del words["cache"]
        return json.dumps(words, sort_keys=True)


@dataclass(frozen=True)
class Item:
    """One picture to make. path: of the input, as the file system gives it (surrogateescape). target: of the
    picture; its folder need not be there yet. size: bytes of the input, 0 where it cannot be told."""

    path: str
    target: str
    size: int = 0


@dataclass(frozen=True)
class Outcome:
    """What became of one item.

    reason: one line, "" when complete. exit_code: what ``trimray render`` would have ended with. sha256: hex,
    of the input's bytes, "" where they could not be read. seconds: wall clock. peak_memory: bytes, of the
    process that read the file or of the one that drew it, whichever was larger. faces: of the model, drawn
    and not; covered: share of the picture that shows the model, 0 to 1.
    """

    path: str
    target: str
    status: Status
    exit_code: int = 0
    reason: str = ""
    sha256: str = ""
    seconds: float = 0.0
    peak_memory: int = 0
    drawn: int = 0
    not_drawn: int = 0
    covered: float = 0.0
