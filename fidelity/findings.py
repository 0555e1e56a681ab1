"""Makers of findings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from .record import NOT_COMPARED, Finding, Section
from .side import Side

# Findings of one name that are listed singly.
MANY = 20


def found(
    section: Section,
    name: str,
    values: Sequence[Any],
    same: bool,
    unit: str = "",
    difference: float | None = None,
    tolerance: float | None = None,
    *,
    missing: bool = False,
    where: str = "",
    reason: str = "",
) -> Finding:
    """values: of A and of B."""
    a, b = values
    return Finding(section, name, a, b, bool(same), unit, difference, tolerance, missing, where, reason)


def count(section: Section, name: str, values: Sequence[Any], where: str = "") -> Finding:
    """Two numbers of things, which should be equal."""
    a, b = (int(value) for value in values)
    return Finding(section, name, a, b, a == b, difference=float(b - a), missing=a != b, where=where)


def not_compared(section: Section, name: str, reason: str) -> Finding:
    """What one of the two cannot have: no difference."""
    return Finding(section, name, None, None, True, reason=f"{NOT_COMPARED}: {reason}")


def not_held(section: Section, what: str, a: Side, b: Side, name: str = "") -> Finding:
    """What the format of one of the two cannot hold. what: as of Side.holds. name: where it is another."""
    lacking = next(side for side in (a, b) if not side.holds(what))
    return not_compared(section, name or what, f"{lacking.format or 'it'} holds none")


def not_comparable(section: Section, name: str, values: Sequence[Any], reason: str) -> Finding:
    """What should have been compared and could not be. values: of A and B, whether it was there."""
    return found(section, name, values, False, missing=True, reason=f"{NOT_COMPARED}: {reason}")


def limited(findings: Iterable[Finding]) -> list[Finding]:
    """The first of many findings of one name, and one that tells of the others."""
    every = list(findings)
    if len(every) <= MANY:
        return every
    rest = every[MANY:]
    missing = any(finding.missing for finding in rest)
    more = Finding(
        rest[0].section, rest[0].name, None, None, False, missing=missing, reason=f"and {len(rest)} more"
    )
    return [*every[:MANY], more]
