"""Report: what became of a file's faces, and what that cost."""

from __future__ import annotations

import resource
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from typing import Any

from .faces import Face

# Runs of face numbers, or entities, named in one line.
_FEW = 12


@dataclass(frozen=True)
class Issue:
    """One entity of the file that was lost, not understood, or changed on reading.

    entity: "#12" in STEP, "D12" in IGES, "face 12", or "". severity: "error" for what is missing from the
    picture, "warning" for what may differ from the file, "note" for the rest.
    """

    entity: str
    kind: str
    reason: str
    severity: str


@dataclass(frozen=True)
class Report:
    """faces_in_file: face entities that the file declares, None where they cannot be counted.
    faces: distinct faces of the model. drawn: those that can be drawn. not_drawn: the others, each with its
        reason as status.
    issues: of the reading; issues_left_out: beyond those listed.
    seconds: wall clock per stage ("parse", "transfer", "store", "extent", "cache" ...; reading stages of a
    cached model are those of the run that filled the cache). peak_memory: bytes, resident, the larger of the
    reading child and this process.
    cached: the model came from the cache.
    """

    faces_in_file: int | None
    faces: int
    drawn: int
    not_drawn: tuple[Face, ...]
    issues: tuple[Issue, ...] = ()
    issues_left_out: int = 0
    seconds: dict[str, float] = field(default_factory=dict)
    reader_memory: int = 0
    cached: bool = False

    @property
    def peak_memory(self) -> int:
        return max(self.reader_memory, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)

    @property
    def complete(self) -> bool:
        """Nothing of the file is missing from the picture."""
        return not self.not_drawn and not any(i.severity == "error" for i in self.issues)

    def damage(self) -> str:
        """One line where the file's text is damaged, since what was read of it may not be what was meant; ""
        when it is sound."""
        found = [issue for issue in self.issues if issue.kind in ("syntax", "knots")]
        if not found:
            return ""
        more = f" and {len(found) - 1} more" if len(found) > 1 else ""
        what = f"{found[0].entity} {found[0].reason}".strip()
        return f"the file is damaged and may be meant otherwise: {what}{more}"

    def problems(self) -> list[str]:
        """One line for each face or entity that is missing: number, kind, reason."""
        lines = [f"{f.call()}: {f.status}" for f in self.not_drawn]
        for issue in self.issues:
            if issue.severity == "error":
                lines.append(f"{issue.entity or 'file'} ({issue.kind}): {issue.reason}")
        if self.issues_left_out:
            lines.append(f"and {self.issues_left_out} more")
        return lines

    def reasons(self) -> list[str]:
        """As problems(), but one line for all faces or entities that differ in their number alone:
        "faces 3, 7-9 (plane of Lid): reason"."""
        groups: dict[tuple[str, str], list[int]] = {}
        for face in self.not_drawn:
            groups.setdefault((face.what, face.status), []).append(face.number)
        lines = [
            f"{'face' if len(n) == 1 else 'faces'} {_ranges(n)} ({what}): {why}"
            for (what, why), n in groups.items()
        ]
        entities: dict[tuple[str, str], list[str]] = {}
        for issue in self.issues:
            if issue.severity == "error":
                entities.setdefault((issue.kind, issue.reason), []).append(issue.entity or "file")
        for (what, why), names in entities.items():
            shown = ", ".join(names[:_FEW]) + (f" and {len(names) - _FEW} more" if len(names) > _FEW else "")
            lines.append(f"{shown} ({what}): {why}")
        if self.issues_left_out:
            lines.append(f"and {self.issues_left_out} more")
        return lines

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "faces_in_file": self.faces_in_file,
            "faces": self.faces,
            "drawn": self.drawn,
            "not_drawn": [
                {"number": f.number, "kind": f.kind, "part": f.part, "name": f.name, "reason": f.status}
                for f in self.not_drawn
            ],
            "issues": [asdict(issue) for issue in self.issues],
            "issues_left_out": self.issues_left_out,
            "seconds": {name: round(value, 6) for name, value in self.seconds.items()},
            "peak_memory": self.peak_memory,
            "cached": self.cached,
            "complete": self.complete,
        }


def make_report(
    faces: Iterable[Face], count: int, source: dict[str, Any], seconds: dict[str, float], cached: bool
) -> Report:
    """source: the importer's report as its meta carries it. faces: those that cannot be drawn."""
    not_drawn = tuple(faces)
    issues = tuple(
        Issue(str(i["entity"]), str(i["kind"]), str(i["reason"]), str(i["severity"]))
        for i in source.get("issues", ())
    )
    return Report(
        faces_in_file=source.get("faces_in_file"),
        faces=count,
        drawn=count - len(not_drawn),
        not_drawn=not_drawn,
        issues=issues,
        issues_left_out=int(source.get("issues_left_out", 0)),
        seconds={**source.get("seconds", {}), **seconds},
        reader_memory=int(source.get("peak_memory", 0)),
        cached=cached,
    )


def _ranges(numbers: list[int]) -> str:
    """Ascending numbers, the first ones of many: "3, 7-9"."""
    runs: list[list[int]] = []
    for n in numbers:
        if runs and n == runs[-1][1] + 1:
            runs[-1][1] = n
        else:
            runs.append([n, n])
    text = ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in runs[:_FEW])
    left = sum(b - a + 1 for a, b in runs[_FEW:])
    return text + (f" and {left} more" if left else "")
