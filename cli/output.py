"""What goes to the terminal: one line an event on stderr, as text or as JSON, data on stdout."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from typing import Any, TextIO

from trimray import OutputError

_json = False


def speak_json(on: bool) -> None:
    """Whether stderr is for programs (--progress json): then every line there is an object."""
    global _json
    _json = on


def colored(stream: TextIO) -> bool:
    """NO_COLOR and FORCE_COLOR decide before the terminal does (no-color.org, force-color.org)."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def emit(event: str, **facts: Any) -> None:
    """One JSON line on stderr. A reader that went away is no reason to fail."""
    with contextlib.suppress(OSError):
        print(json.dumps({"event": event, **facts}), file=sys.stderr, flush=True)


def say(text: str, *, error: bool = False, event: str = "message", **facts: Any) -> None:
    """One line on stderr. A terminal that went away is no reason to fail.

    event, facts: what a program is told beside the text, JSON-able.
    """
    line = " ".join(text.splitlines())
    if _json:
        emit(event, level="error" if error else "info", text=line, **facts)
        return
    head = "trimray:"
    if colored(sys.stderr):
        head = f"\x1b[1;{'31' if error else '33'}m{head}\x1b[0m"
    with contextlib.suppress(OSError):
        print(f"{head} {line}", file=sys.stderr, flush=True)


def shown_path(path: str) -> str:
    """For a message: relative to the working folder where it lies in there, on one line, without what a
    terminal would obey or could not print."""
    try:
        here = os.getcwd()
    except OSError:
        here = ""
    if here and path.startswith(here.rstrip("/") + "/"):
        path = path[len(here.rstrip("/")) + 1 :]
    return printable(path)


def printable(text: str) -> str:
    """Line ends, control characters and bytes that are no text as escapes."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def json_text(data: object) -> str:
    """Indented, and with letters as they are."""
    return json.dumps(data, indent=2, ensure_ascii=False) + "\n"


def write_stdout(data: bytes | str) -> None:
    """Data on stdout, flushed. Raises OutputError."""
    if sys.stdout is None:  # closed by the caller
        raise OutputError("stdout: not written: Bad file descriptor")
    try:
        sys.stdout.flush()
        stream = getattr(sys.stdout, "buffer", None)
        if stream is None:
            sys.stdout.write(data if isinstance(data, str) else data.decode())
        else:
            stream.write(data.encode("utf-8", "surrogateescape") if isinstance(data, str) else data)
            stream.flush()
    except OSError as error:
        # What is still in the buffer must not raise once more when the interpreter ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise OutputError(f"stdout: not written: {error.strerror or error}") from None
