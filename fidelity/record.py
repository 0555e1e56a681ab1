"""What a comparison says: values of A and of B side by side, each with its tolerance. Plain records."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

Section = Literal["file", "structure", "topology", "mass", "geometry", "pictures"]
SECTIONS: tuple[Section, ...] = ("file", "structure", "topology", "mass", "geometry", "pictures")

# complete: nothing differs. changed: both are there, and something differs. partial: B lacks something of A,
# or A of B, or something could not be compared. empty: B holds no geometry at all. failed: B could not be
# written or read.
Verdict = Literal["complete", "changed", "partial", "empty", "failed"]

# How the reason begins of what was not compared.
NOT_COMPARED = "not compared"


@dataclass(frozen=True)
class Finding:
    """One quantity, compared.

    name: such as "volume" or "faces of kind plane". a, b: the values, JSON-able; None: there is none.
    difference: of a and b in the unit of the tolerance, None where it is no number. tolerance: what
    difference may be; None: only equality will do. missing: b lacks something that a has, or a of b.
    where: the place, such as "face 12 (plane of Lid)"; "" for the whole model. reason: why they may differ or
    could not be compared.
    """

    section: Section
    name: str
    a: Any
    b: Any
    same: bool
    unit: str = ""
    difference: float | None = None
    tolerance: float | None = None
    missing: bool = False
    where: str = ""
    reason: str = ""

    @property
    def uncompared(self) -> bool:
        """It should have been compared, and could not be."""
        return not self.same and self.reason.startswith(NOT_COMPARED)


@dataclass(frozen=True)
class Picture:
    """One view of both. differing: pixels that differ, by plane ("depth", "normal", "coverage"); the images
    are encoded PNG: a, b and their overlay; b"" where they were not asked for."""

    view: str
    size: tuple[int, int]
    differing: dict[str, int]
    a: bytes = b""
    b: bytes = b""
    overlay: bytes = b""


@dataclass(frozen=True)
class Comparison:
    """A against B. a, b: what messages call them. profile: of ``tolerances``."""

    a: str
    b: str
    profile: str
    findings: tuple[Finding, ...]
    pictures: tuple[Picture, ...] = ()
    error: str = ""  # why B could not be made or read: verdict "failed" or "empty"
    seconds: dict[str, float] = field(default_factory=dict)
    verdict: Verdict = "complete"

    def differences(self) -> tuple[Finding, ...]:
        return tuple(finding for finding in self.findings if not finding.same)


def verdict_of(findings: tuple[Finding, ...]) -> Verdict:
    """Of two models that were both read."""
    different = [finding for finding in findings if not finding.same]
    if not different:
        return "complete"
    return "partial" if any(finding.missing for finding in different) else "changed"
