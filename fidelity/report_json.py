"""Results as JSON, as schema.json describes it."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from importlib import resources
from typing import Any

from trimray import __version__
from trimray.web_page import encodable

from .record import Comparison, Finding, Picture
from .result import Result
from .tolerances import PROFILES

# Counts up when a reader of the old form would misunderstand the new one.
FORMAT = 1


def document(results: Sequence[Result]) -> dict[str, Any]:
    """What is written: plain values, none of them infinite or not a number."""
    document = {"format": FORMAT, "trimray": __version__, "results": [_result(result) for result in results]}
    cleaned: dict[str, Any] = plain(document)
    return cleaned


def to_json(results: Sequence[Result]) -> bytes:
    text = json.dumps(document(results), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode()


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of what ``to_json`` writes."""
    text = resources.files(__package__).joinpath("schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def plain(value: Any) -> Any:
    """What JSON can hold, of whatever a finding's value is: numbers that are none become text, arrays lists,
    and what is no UTF-8 in a path is escaped."""
    if isinstance(value, dict):
        return {plain(str(key)): plain(item) for key, item in value.items()}
    if isinstance(value, str):
        return encodable(value)
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):  # of numpy
        return plain(value.tolist())
    return plain(str(value))


def _result(result: Result) -> dict[str, Any]:
    return {
        "input": result.input,
        "command": result.command,
        "verdict": result.verdict,
        "exit_code": result.exit_code,
        "error": result.error,
        "comparisons": [_comparison(comparison) for comparison in result.comparisons],
    }


def _comparison(comparison: Comparison) -> dict[str, Any]:
    tolerances = PROFILES.get(comparison.profile)
    return {
        "a": comparison.a,
        "b": comparison.b,
        "profile": comparison.profile,
        "tolerances": vars(tolerances) if tolerances else {},
        "verdict": comparison.verdict,
        "error": comparison.error,
        "values": len(comparison.findings),
        "differences": len(comparison.differences()),
        "findings": [_finding(finding) for finding in comparison.findings],
        "pictures": [_picture(picture) for picture in comparison.pictures],
        "seconds": {stage: round(value, 6) for stage, value in comparison.seconds.items()},
    }


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        "section": finding.section,
        "name": finding.name,
        "where": finding.where,
        "a": finding.a,
        "b": finding.b,
        "same": finding.same,
        "missing": finding.missing,
        "difference": _number(finding.difference),
        "tolerance": _number(finding.tolerance),
        "unit": finding.unit,
        "reason": finding.reason,
    }


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


def _picture(picture: Picture) -> dict[str, Any]:
    return {"view": picture.view, "size": list(picture.size), "differing": dict(picture.differing)}
