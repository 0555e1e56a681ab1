"""What was not transferred, and why; what each stage cost."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Severity = Literal["error", "warning", "note"]

# More issues than this are counted, not listed: a broken file may have one per entity.
_MOST_ISSUES = 2000


# What healing says when the same points are only drawn another way: no change of any shape.
_SAME_SHAPE = (
    "Missing seam-edge added",
    "Surface forced to be periodic",
    "Surface is made periodic",
    "was split into C1 continuity",
    "C0continuous",
)


def changes_shape(messages: list[str]) -> bool:
    """Does one of the messages of healing tell of more than another way to draw the same points?"""
    return not all(any(harmless in message for harmless in _SAME_SHAPE) for message in messages)


@dataclass(frozen=True)
class Issue:
    """One face or entity that was lost, not understood, or changed.

    entity: "#12" in STEP, "D12" (directory entry) in IGES, "face 12" (shape index), or "".
    severity: "error" for what is missing from the model, "warning" for what may differ from the file,
    "note" for what a reader of the report should know.
    """

    entity: str
    kind: str
    reason: str
    severity: Severity = "error"


@dataclass
class Report:
    """Filled while a file is read; becomes ``BrepModel.report`` through ``as_dict``."""

    format: str = ""
    faces_in_file: int | None = None  # face entities that the file's text declares; None: not countable
    faces: int = 0  # distinct faces that arrived
    face_uses: int = 0  # over all instances
    issues: list[Issue] = field(default_factory=list)
    issues_left_out: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    peak_memory: int = 0  # bytes, resident, of the reading process
    on_stage: Callable[[str], None] | None = None

    def add(self, entity: str, kind: str, reason: str, severity: Severity = "error") -> None:
        """Records an issue; the same one twice is one."""
        issue = Issue(entity, kind, " ".join(reason.split()), severity)
        if issue in self.issues[-8:]:
            return
        if len(self.issues) < _MOST_ISSUES:
            self.issues.append(issue)
        else:
            self.issues_left_out += 1

    def add_curves(self, shapes: int) -> None:
        """Notes how many shapes of the file have no face, which is no loss."""
        if shapes:
            what = "1 shape is" if shapes == 1 else f"{shapes} shapes are"
            self.add("", "shape", f"{what} curves or points: not drawn", "note")

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Times a stage (seconds add up when it is entered again) and announces it."""
        if self.on_stage is not None:
            self.on_stage(name)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "format": self.format,
            "faces_in_file": self.faces_in_file,
            "faces": self.faces,
            "face_uses": self.face_uses,
            "issues": [asdict(issue) for issue in self.issues],
            "issues_left_out": self.issues_left_out,
            "seconds": {name: round(value, 6) for name, value in self.seconds.items()},
            "peak_memory": self.peak_memory,
        }
