"""Results as one self-contained page: what differs, and the pictures beside and over each other."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from importlib import resources
from typing import Any

from trimray import __version__
from trimray.web_page import make_page, shown, texts_of

from .record import Picture
from .report_json import document
from .result import Result

_SCRIPTS = ("report_values.js", "report_pictures.js", "report.js")
_TITLES = {"check": "Check", "roundtrip": "Round trip", "compare": "Comparison"}


def to_html(results: Sequence[Result]) -> bytes:
    """Pictures are in the page, as data. Equal results give equal bytes."""
    own = resources.files(__package__)
    data = _escaped(document(results))
    for result, about in zip(results, data["results"], strict=True):
        for comparison, written in zip(result.comparisons, about["comparisons"], strict=True):
            for picture, facts in zip(comparison.pictures, written["pictures"], strict=True):
                facts |= _images(picture)
    return make_page(
        *texts_of(own, "report.html"),
        title=_title(results),
        note=f"trimray {__version__}",
        styles=texts_of(own, "report.css"),
        scripts=texts_of(own, *_SCRIPTS),
        data=data,
        images="data:",
    )


def _title(results: Sequence[Result]) -> str:
    commands = {_TITLES[result.command] for result in results}
    title = commands.pop() if len(commands) == 1 else "Report"
    return f"{title}: {results[0].input}" if len(results) == 1 else title


def _images(picture: Picture) -> dict[str, str]:
    """One picture of both where they are the same to the byte, as they are in a clean round trip."""
    images = {name: _data_uri(getattr(picture, name)) for name in ("a", "b", "overlay")}
    return images if images["a"] != images["b"] else images | {"b": "a"}


def _data_uri(png: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(png).decode()}" if png else ""


def _escaped(value: Any) -> Any:
    """All texts, with what cannot be seen in escapes: names of models are anybody's."""
    if isinstance(value, str):
        return shown(value)
    if isinstance(value, dict):
        return {shown(key): _escaped(item) for key, item in value.items()}
    return [_escaped(item) for item in value] if isinstance(value, list) else value
