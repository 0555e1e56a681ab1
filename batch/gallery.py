"""The gallery of a batch: one self-contained page beside the pictures, for any browser, without a network."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
from collections.abc import Iterable, Mapping
from importlib import resources
from typing import TYPE_CHECKING
from urllib.parse import quote_from_bytes

from trimray import OutputError, __version__
from trimray.image_io import write_file

from .record import STATUSES, Outcome, Settings
from .run import settings_of

if TYPE_CHECKING:
    from .state import Row, State

NAME = "index.html"

# What tells a page of ours from someone else's, which is not overwritten.
_MARK = '<meta name="generator" content="trimray '

_SCRIPTS = ("gallery_entries.js", "gallery_grid.js", "gallery_detail.js", "gallery.js")

# Everything that is not in the page itself is forbidden, pictures beside it excepted. "file:": a page that is
# opened from a disk has no origin that 'self' could name.
_POLICY = (
    "default-src 'none'; img-src 'self' file: data:; style-src {style}; script-src {script}; "
    "base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'"
)

# Characters that would break a line, or turn the reading direction of what stands beside them.
_UNSEEN = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]"
)

# A reason is one line; one longer than this is not an explanation.
_LONGEST_REASON = 600


def check_gallery(folder: str | os.PathLike[str]) -> None:
    """Says before hours of work what ``write_gallery`` would say after them.

    Raises OutputError where index.html is something else than a gallery of ours.
    """
    path = os.path.join(os.fspath(folder), NAME)
    if not os.path.lexists(path):
        return
    start = b""
    if os.path.isfile(path):  # a pipe would have no end
        try:
            with open(path, "rb") as file:
                start = file.read(4096)
        except OSError as error:
            raise OutputError(f"{path}: not written: {error.strerror}") from None
    if _MARK.encode() not in start:
        raise OutputError(f"{path}: not written: it is there already, and no gallery of trimray's")


def write_gallery(
    folder: str | os.PathLike[str],
    outcomes: Iterable[Outcome],
    *,
    title: str = "",
    settings: Settings | None = None,
    sizes: Mapping[str, int] | None = None,
) -> str:
    """Writes ``index.html`` to folder, whole or not at all, and returns its path.

    The pictures stay where they are: the page names them relative to folder. title: by default the name of
    the folder. settings: told in the page's head. sizes: bytes of the inputs by path, where known. Equal
    arguments give equal bytes, in whatever order the outcomes come. About 0.3 KiB an outcome; all are held in
    memory, here and in the browser, which is quick up to some ten thousand of them.

    Raises OutputError when the page cannot be written, or index.html is something else than a gallery.
    """
    folder = os.path.abspath(os.fspath(folder))
    check_gallery(folder)
    rows = sorted(outcomes, key=lambda outcome: (outcome.path, outcome.target))
    root = _root(rows)
    data = {
        "root": _shown(root),
        "statuses": STATUSES,
        "aspect": settings.size[1] / settings.size[0] if settings else 1.0,
        "rows": [_row(outcome, folder, root, (sizes or {}).get(outcome.path, -1)) for outcome in rows],
    }
    page = _page(title or os.path.basename(folder) or folder, settings, _json(data))
    path = os.path.join(folder, NAME)
    write_file(path, page)
    return path


def write_gallery_of_state(folder: str, state: State) -> str:
    """The same, of all files that the state in folder knows, of whichever run.

    Files that are not done are left out, and where two files have had one picture, the one that has lost it.
    """
    rows: dict[tuple[bool, str], Row] = {}
    for row in state.rows():
        if row.status == "pending":
            continue
        failed = row.status == "failed"
        picture = (failed, row.path if failed else row.target)
        if picture not in rows or rows[picture].finished < row.finished:
            rows[picture] = row
    outcomes = [outcome for row in rows.values() if (outcome := row.outcome(folder))]
    keys = {row.settings for row in rows.values()}
    settings = settings_of(json.loads(keys.pop())) if len(keys) == 1 and "" not in keys else None
    return write_gallery(
        folder, outcomes, settings=settings, sizes={row.path: row.size for row in rows.values()}
    )


def _root(outcomes: list[Outcome]) -> str:
    """The deepest folder that holds all inputs; the page tells it once and paths below it."""
    folders = {os.path.dirname(os.path.abspath(outcome.path)) for outcome in outcomes}
    return os.path.commonpath(folders) if folders else ""


def _row(outcome: Outcome, folder: str, root: str, size: int) -> list[str | int | float]:
    """One entry, in the order in which gallery_entries.js takes it apart."""
    link = "" if outcome.status == "failed" else _link(outcome.target, folder)
    return [
        _shown(os.path.relpath(os.path.abspath(outcome.path), root)),
        link,
        STATUSES.index(outcome.status),
        outcome.drawn,
        outcome.not_drawn,
        round(outcome.seconds, 3),
        round(outcome.peak_memory / (1 << 20), 1),
        size,
        round(outcome.covered, 4),
        outcome.sha256,
        _reason(outcome),
    ]


def _link(target: str, folder: str) -> str:
    """A relative URL. Its colons are escaped as well, so that no name passes for a scheme (javascript:)."""
    return quote_from_bytes(os.fsencode(os.path.relpath(os.path.abspath(target), folder)), safe="/")


def _reason(outcome: Outcome) -> str:
    """Without path and status in front, which stand beside it already."""
    text = outcome.reason
    for known in (outcome.path, os.path.basename(outcome.path), outcome.status):
        text = text.removeprefix(f"{known}: ")
    text = _shown(text)
    return text if len(text) <= _LONGEST_REASON else f"{text[: _LONGEST_REASON - 1]}…"


def _shown(path: str) -> str:
    """A path as text: what is not UTF-8, and what cannot be seen, in the escapes of Python and C."""
    text = os.fsencode(path).decode("utf-8", "backslashreplace")
    return _UNSEEN.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def _json(data: object) -> str:
    """JSON that may stand inside <script>: no "<" can end it, or begin a comment."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return text.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _page(title: str, settings: Settings | None, data: str) -> bytes:
    style = _read("gallery.css")
    script = "\n".join(_read(name) for name in _SCRIPTS)
    policy = _POLICY.format(style=_source(style), script=_source(script))
    parts = {
        "mark": f'{_MARK}{html.escape(__version__)}">',
        "policy": html.escape(policy, quote=False),
        "title": html.escape(_shown(title)),
        "note": html.escape(_note(settings)),
        "style": style,
        "data": data,
        "script": script,
    }
    # One pass, so that a name such as {{script}} in the data stays what it is.
    page = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _read("gallery.html"))
    return page.encode()


def _note(settings: Settings | None) -> str:
    if settings is None:
        return f"trimray {__version__}"
    width, height = settings.size
    words = [
        f"{width} × {height} px",
        settings.view,
        settings.projection,
        f"{settings.up} up",
        settings.format,
    ]
    if settings.heal != "default":
        words.append(f"heal {settings.heal}")
    return " · ".join([*words, f"trimray {__version__}"])


def _source(text: str) -> str:
    """The name of an inline style or script in a Content-Security-Policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _read(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
