"""The gallery of a batch: one self-contained page beside the pictures, for any browser, without a network."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from importlib import resources
from typing import TYPE_CHECKING
from urllib.parse import quote_from_bytes

from trimray import __version__
from trimray.image_io import write_file
from trimray.web_page import check_page, make_page, shown, texts_of

from .record import STATUSES, Outcome, Settings
from .run import settings_of

if TYPE_CHECKING:
    from .state import Row, State

NAME = "index.html"

_SCRIPTS = ("gallery_entries.js", "gallery_grid.js", "gallery_detail.js", "gallery.js")

# "file:": a page that is opened from a disk has no origin that 'self' could name.
_IMAGES = "'self' file: data:"

# A reason is one line; one longer than this is not an explanation.
_LONGEST_REASON = 600


def check_gallery(folder: str | os.PathLike[str]) -> None:
    """Says before hours of work what ``write_gallery`` would say after them.

    Raises OutputError where index.html is something else than a gallery of ours.
    """
    check_page(os.path.join(os.fspath(folder), NAME), "gallery")


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
        "root": shown(os.path.basename(root)),
        "statuses": STATUSES,
        "aspect": settings.size[1] / settings.size[0] if settings else 1.0,
        "rows": [_row(outcome, folder, root, (sizes or {}).get(outcome.path, -1)) for outcome in rows],
    }
    own = resources.files(__package__)
    page = make_page(
        *texts_of(own, "gallery.html"),
        title=title or os.path.basename(folder) or folder,
        note=_note(settings),
        styles=texts_of(own, "gallery.css"),
        scripts=texts_of(own, *_SCRIPTS),
        data=data,
        images=_IMAGES,
    )
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
    """The deepest folder that holds all inputs. The page tells its name, and paths below it: where that lies
    on somebody's disk is nobody's business who is given the page."""
    folders = {os.path.dirname(os.path.abspath(outcome.path)) for outcome in outcomes}
    return os.path.commonpath(folders) if folders else ""


def _row(outcome: Outcome, folder: str, root: str, size: int) -> list[str | int | float]:
    """One entry, in the order in which gallery_entries.js takes it apart."""
    link = "" if outcome.status == "failed" else _link(outcome.target, folder)
    return [
        shown(os.path.relpath(os.path.abspath(outcome.path), root)),
        link,
        STATUSES.index(outcome.status),
        outcome.drawn,
        outcome.not_drawn,
        round(outcome.seconds, 3),
        round(outcome.peak_memory / (1 << 20), 1),
        size,
        round(outcome.covered, 4),
        outcome.sha256,
        _reason(outcome, (root, folder)),
    ]


def _link(target: str, folder: str) -> str:
    """A relative URL. Its colons are escaped as well, so that no name passes for a scheme (javascript:)."""
    return quote_from_bytes(os.fsencode(os.path.relpath(os.path.abspath(target), folder)), safe="/")


def _reason(outcome: Outcome, folders: tuple[str, str]) -> str:
    """Without path and status in front, which stand beside it already, and without where the folders lie."""
    text = outcome.reason
    for known in (outcome.path, os.path.basename(outcome.path), outcome.status):
        text = text.removeprefix(f"{known}: ")
    for known in folders:
        text = text.replace(f"{known.rstrip('/')}/", "") if known != "/" else text
    text = shown(text)
    return text if len(text) <= _LONGEST_REASON else f"{text[: _LONGEST_REASON - 1]}…"


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
