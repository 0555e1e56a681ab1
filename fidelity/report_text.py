"""Results as text for a terminal: the verdict first, then a table of what differs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from trimray.web_page import shown

from .record import SECTIONS, Comparison, Finding
from .result import Result

# Characters of a value in a cell; the JSON has all of it.
_WIDEST = 44
# A reason of at most so many characters stands beside its values, a longer one below them.
_SHORT = 32
# Rows of one table; the JSON has all of them.
_MOST_ROWS = 200

_HEAD = ("", "", "A", "B", "difference", "tolerance")


def to_text(results: Sequence[Result], *, everything: bool = False) -> str:
    """everything: also the values that agree."""
    return "\n".join(_result(result, everything) for result in results)


def summary(comparison: Comparison) -> str:
    """ "3 of 60 values differ, 1 not compared"."""
    different, count = comparison.differences(), len(comparison.findings)
    lacking = sum(finding.uncompared for finding in different)
    parts = [f"{len(different) - lacking} of {count} values differ"] if lacking < len(different) else []
    if lacking:
        parts.append(f"{lacking} not compared" if parts else f"{lacking} of {count} values not compared")
    return ", ".join(parts) or f"{count} values agree"


def line_of(finding: Finding) -> str:
    """One finding in a line."""
    where = f" of {finding.where}" if finding.where else ""
    parts = [f"{finding.name}{where}: {value_text(finding.a)} - {value_text(finding.b)}"]
    if finding.difference is not None:
        parts.append(f"difference {_quantity(finding.difference, finding.unit)}")
    if finding.tolerance is not None:
        parts.append(f"tolerance {_quantity(finding.tolerance, finding.unit)}")
    if finding.reason:
        parts.append(finding.reason)
    return shown(", ".join(parts))


def value_text(value: Any) -> str:
    """A value for the eye: numbers to 12 digits, which is what the strictest profile can tell apart."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.12g}" if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {value_text(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return f"({', '.join(value_text(item) for item in value)})"
    return str(value)


def _result(result: Result, everything: bool) -> str:
    name = shown(result.input)
    if not result.comparisons:
        return f"{name}: {result.verdict}: {shown(result.error)}\n"
    return "".join(_comparison(name, comparison, everything) for comparison in result.comparisons)


def _comparison(name: str, comparison: Comparison, everything: bool) -> str:
    different = comparison.differences()
    about = _about(name, shown(comparison.a), shown(comparison.b))
    head = f"{name}: {comparison.verdict}{about}: "
    if comparison.error:
        return f"{head}{shown(comparison.error)}\n"
    head += f"{summary(comparison)} ({comparison.profile} tolerances)\n"
    rows = comparison.findings if everything else different
    # What differs comes first, also among everything.
    return head + _table(sorted(rows, key=lambda finding: (finding.same, SECTIONS.index(finding.section))))


def _about(name: str, a: str, b: str) -> str:
    """What of both names the input's name does not say already."""
    if b in name:
        return ""
    return f": {b.removeprefix(name).lstrip(' ,')}"


def _table(findings: list[Finding]) -> str:
    if not findings:
        return ""
    lines: list[tuple[tuple[str, ...], str]] = [(_HEAD, "")]
    section = ""
    for finding in findings[:_MOST_ROWS]:
        cells: tuple[str, ...] = (
            finding.section if finding.section != section else "",
            _cut(
                f"{'' if finding.same else '! '}{finding.name}{f', {finding.where}' if finding.where else ''}"
            ),
            _cut(value_text(finding.a)),
            _cut(value_text(finding.b)),
            "" if finding.difference is None else _quantity(finding.difference, finding.unit),
            _tolerance(finding),
        )
        lines.append((cells, shown(finding.reason)))
        section = finding.section
    widths = [max(len(cells[k]) for cells, _ in lines) for k in range(len(_HEAD))]
    text = ""
    for row_cells, reason in lines:
        row = "  ".join(f"{cell:{width}}" for cell, width in zip(row_cells, widths, strict=True))
        beside = len(reason) <= _SHORT
        text += f"  {row}  {reason}".rstrip() + "\n" if beside else f"  {row.rstrip()}\n"
        if not beside:
            text += f"  {'':{widths[0]}}    {reason}\n"
    if len(findings) > _MOST_ROWS:
        text += f"  and {len(findings) - _MOST_ROWS} more; --json has all\n"
    return text


def _tolerance(finding: Finding) -> str:
    if finding.tolerance is not None:
        return _quantity(finding.tolerance, finding.unit)
    return "" if finding.reason.startswith("not ") else "equal"


def _quantity(value: float, unit: str) -> str:
    number = f"{value:.0f}" if float(value).is_integer() and abs(value) < 1e9 else f"{value:.3g}"
    return f"{number} {unit}".rstrip()


def _cut(text: str) -> str:
    text = shown(text)
    return text if len(text) <= _WIDEST else f"{text[: _WIDEST - 1]}…"
