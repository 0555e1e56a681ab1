"""What a failed assertion says, and the pictures and the report that it leaves."""

from __future__ import annotations

import fnmatch
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import trimray
from trimray.image_io import write_file

from .record import SECTIONS, Comparison, Finding, verdict_of
from .report_html import to_html
from .report_text import line_of, summary
from .result import Command, Result
from .running import FAILURE, Running

# Findings that a message shows, those of one name, and views whose pictures are saved.
_FINDINGS = 8
_ALIKE = 2
_VIEWS = 2
# Ends of the names of all files that are saved.
_OURS = (".a.png", ".b.png", ".overlay.png", ".golden.png", ".now.png", "report.html")


def check_comparisons(
    running: Running,
    command: Command,
    make: Callable[[bool], Sequence[Comparison]],
    *,
    sections: Sequence[str] = SECTIONS,
    ignore: str | Sequence[str] = (),
) -> str:
    """What differs, "" for nothing. Raises UsageError.

    make: of whether colours count, in pictures, too. sections: those that count. ignore: patterns of names or
    sections of findings.
    """
    wrong = set(sections) - set(SECTIONS)
    if wrong or isinstance(sections, str):
        raise trimray.UsageError(f"sections: not all of {sections!r} are among: {', '.join(SECTIONS)}")
    patterns = [ignore] if isinstance(ignore, str) else list(ignore)
    try:
        colors = "structure" in sections and not _is_any("colour", "structure", patterns)
        comparisons = [_judged(comparison, sections, patterns) for comparison in make(colors)]
    except trimray.UsageError:
        raise
    except trimray.Error as error:
        return str(error)
    failed = [comparison for comparison in comparisons if comparison.verdict != "complete"]
    if not failed:
        return ""
    result = Result(failed[0].a, command, tuple(comparisons), exit_code=7)
    files = {"report.html": to_html([result])}
    for comparison in failed[:1]:
        files |= _pictures(comparison)
    return "\n".join(line for comparison in failed for line in _lines(comparison)) + save(running, files)


def _judged(comparison: Comparison, sections: Sequence[str], ignore: Sequence[str]) -> Comparison:
    """What counts of a comparison, and the verdict on that."""
    if comparison.verdict in ("failed", "empty"):
        return comparison
    findings = tuple(
        finding
        for finding in comparison.findings
        if finding.section in sections and not _is_any(finding.name, finding.section, ignore)
    )
    return replace(comparison, findings=findings, verdict=verdict_of(findings))


def _is_any(name: str, section: str, patterns: Sequence[str]) -> bool:
    return any(fnmatch.fnmatchcase(word, pattern) for pattern in patterns for word in (name, section))


def _lines(comparison: Comparison) -> list[str]:
    different = sorted(comparison.differences(), key=_badness)
    head = f"B ({comparison.b}) against A ({comparison.a}): {comparison.verdict}"
    if comparison.error:
        return [f"{head}: {comparison.error}"]
    lines = [f"{head}: {summary(comparison)} (profile {comparison.profile})"]
    some = _varied(different)
    lines += [f"  {finding.section}: {line_of(finding)}" for finding in some]
    if len(different) > len(some):
        lines.append(f"  and {len(different) - len(some)} more")
    faces = [finding.where for finding in different if finding.where.startswith("face ")]
    return [*lines, f"  worst: {faces[0]}"] if faces else lines


def _varied(findings: Sequence[Finding]) -> list[Finding]:
    """The first ones, few of each name."""
    seen: Counter[tuple[str, str]] = Counter()
    few = []
    for finding in findings:
        seen[finding.section, finding.name] += 1
        if seen[finding.section, finding.name] <= _ALIKE:
            few.append(finding)
    return few[:_FINDINGS]


def _badness(finding: Finding) -> tuple[float, ...]:
    """What is missing first, then what is most beyond its tolerance; pictures, which show it all, last."""
    last = finding.section == "pictures"
    beyond = 0.0
    if finding.difference is not None and finding.tolerance is not None:
        beyond = abs(finding.difference) / max(finding.tolerance, 1e-300)
    return last, not finding.missing, -beyond


def _pictures(comparison: Comparison) -> dict[str, bytes]:
    """Of the views that differ most, or of the first one; by file name."""
    drawn = [picture for picture in comparison.pictures if picture.overlay]
    drawn = [picture for picture in drawn if any(picture.differing.values())] or drawn[:1]
    drawn.sort(key=lambda picture: -sum(picture.differing.values()))
    return {
        f"{picture.view}.{name}.png": getattr(picture, name)
        for picture in drawn[:_VIEWS]
        for name in ("a", "b", "overlay")
    }


def save(running: Running, files: Mapping[str, bytes]) -> str:
    """Writes what a failure leaves; returns the end of its message, which says where."""
    running.failures += 1
    name = running.folder_name() + (f"-{running.failures}" if running.failures > 1 else "")
    reason = ""
    try:
        folder = _fresh(running, name)
        _write(folder, files)
    except (OSError, trimray.OutputError) as error:  # as in a checkout that cannot be written to
        reason = f" ({running.shown(running.report)}: {getattr(error, 'strerror', None) or error})"
        folder = Path(tempfile.mkdtemp(prefix="trimray-failure-"))
        _write(folder, files)
    shown = running.shown(folder)
    running.notes.append((FAILURE, shown))
    return f"\n  saved in {shown}{reason}: {', '.join(files)}"


def _write(folder: Path, files: Mapping[str, bytes]) -> None:
    for file, data in files.items():
        write_file(str(folder / file), data)


def _fresh(running: Running, name: str) -> Path:
    """The folder of one failure, without what an earlier run left in it."""
    report = running.report
    report.mkdir(parents=True, exist_ok=True)
    if not running.chosen and not (report / ".gitignore").exists():
        (report / ".gitignore").write_text("*\n")
    folder = report / name
    folder.mkdir(exist_ok=True)
    for file in folder.iterdir():
        if file.name.endswith(_OURS):
            file.unlink()
    return folder
