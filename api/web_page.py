"""Self-contained pages for any browser, without a network: styles and scripts stand in the page, and no
others are allowed in it."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
from collections.abc import Sequence
from importlib import resources
from importlib.resources.abc import Traversable

from .importer.errors import OutputError
from .version import __version__

# What tells a page of ours from someone else's, which is not overwritten.
_MARK = '<meta name="generator" content="trimray '

# Everything that is not in the page itself is forbidden, images excepted.
_POLICY = (
    "default-src 'none'; img-src {images}; style-src {style}; script-src {script}; "
    "base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'"
)

# Characters that would break a line, or turn the reading direction of what stands beside them.
_UNSEEN = re.compile(
    r"[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]"
)


def shown(text: str) -> str:
    """A path or a name as text: what is not UTF-8, and what cannot be seen, in the escapes of Python."""
    return _UNSEEN.sub(lambda match: match[0].encode("unicode_escape").decode(), encodable(text))


def encodable(text: str) -> str:
    """A path or a name with escapes for what is not UTF-8."""
    try:
        return os.fsencode(text).decode("utf-8", "backslashreplace")
    except UnicodeEncodeError:  # a lone surrogate that stands for no byte
        return text.encode("utf-8", "backslashreplace").decode()


def make_page(
    body: str,
    *,
    title: str,
    note: str,
    styles: Sequence[str],
    scripts: Sequence[str],
    data: object,
    images: str,
) -> bytes:
    """A page.

    body: its HTML, in which {{title}} and {{note}} stand for these. styles, scripts: texts, put together in
        this order behind the shared ones (web_page.css, web_page.js). data: JSON-able, for the scripts.
    images: sources that the page's policy allows for them, such as "data:".
    """
    shared = resources.files(__package__)
    style = "\n".join([*texts_of(shared, "web_page.css"), *styles])
    script = "\n".join([*texts_of(shared, "web_page.js"), *scripts])
    template = texts_of(shared, "web_page.html")[0].replace("{{body}}", body)
    policy = _POLICY.format(images=images, style=_source(style), script=_source(script))
    parts = {
        "mark": f'{_MARK}{html.escape(__version__)}">',
        "policy": html.escape(policy, quote=False),
        "title": html.escape(shown(title)),
        "note": html.escape(shown(note)),
        "style": style,
        "data": _json(data),
        "script": script,
    }
    # One pass, so that a name such as {{script}} in the data stays what it is.
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], template).encode()


def check_page(path: str, what: str) -> None:
    """Says before hours of work what writing would say after them.

    what: the page is called. Raises OutputError where path is something else than a page of ours.
    """
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
        raise OutputError(f"{path}: not written: it is there already, and no {what} of trimray's")


def texts_of(folder: Traversable, *names: str) -> list[str]:
    """Of files that the package holds."""
    return [folder.joinpath(name).read_text(encoding="utf-8") for name in names]


def _json(data: object) -> str:
    """JSON that may stand inside <script>: no "<" can end it, or begin a comment."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return text.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def _source(text: str) -> str:
    """The name of an inline style or script in a Content-Security-Policy."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
