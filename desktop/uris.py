"""file:// URIs as GLib writes them, whose MD5 names a thumbnail in the freedesktop cache."""

from __future__ import annotations

import os
from urllib.parse import quote_from_bytes, unquote_to_bytes

# What g_filename_to_uri leaves as it is, beside letters and digits: the thumbnail of a file is only found by
# other programs where every byte is escaped as they do.
_PLAIN = "-_.~!$&'()*+,:=@/"


def file_uri(path: str) -> str:
    """The URI of a file. path: absolute or not, of any bytes (surrogateescape); links are not followed, since
    file managers do not either."""
    return "file://" + quote_from_bytes(os.fsencode(os.path.abspath(path)), _PLAIN)


def path_of(text: str) -> str:
    """The path that a file:// URI names; any other text is a path. Raises ValueError: another scheme, another
    machine, a NUL byte."""
    scheme, colon, rest = text.partition("://")
    if not colon or not scheme.isalnum():
        return text
    if scheme.lower() != "file":
        raise ValueError(f"'{scheme}' is not a file")
    host, slash, path = rest.partition("/")
    if not slash or host.lower() not in ("", "localhost"):
        raise ValueError(f"no file on this machine: {text}")
    data = unquote_to_bytes(os.fsencode(slash + path))
    if b"\0" in data:
        raise ValueError("a NUL byte in the path")
    return os.fsdecode(data)
